"""Figure of a trajectory: its path in space and the motion and torque of each joint."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection  # type: ignore[import-untyped]

from delta_web.palette import JOINTS
from recordings.recording import Floats
from recordings.rig import Limits, Rig
from trajectories.checks import torque_estimate
from trajectories.trajectory import Trajectory

QUIET, SHADOW, RAMP, LIMIT = "#6A6A6A", "#CFCFCF", "#F0F0F0", "#B00020"
SPEED_COLOURS = "viridis"


def draw(trajectory: Trajectory, rig: Rig) -> Figure:
    """Plot the path, and angle, speed, acceleration and torque estimate of every joint, with the limits of `rig`.

    Only the lead-in and the first of the identical repetitions are shown.
    """
    shown = slice(0, int(np.flatnonzero(trajectory.repeat == 0)[-1]) + 2) if trajectory.period else slice(None)
    figure = Figure(figsize=(13, 8), dpi=120)
    figure.text(0.03, 0.95, f"{trajectory.name}: {trajectory.description}", fontsize=13, fontweight="bold")
    figure.text(0.03, 0.925, _caption(trajectory), color=QUIET, fontsize=9.5)
    _draw_views(figure, trajectory.platform[shown], trajectory.rate, rig.limits)
    limits, time = rig.limits, trajectory.time[shown]
    ramps = trajectory.repeat[shown] < 0
    rows = (
        ("angle [rad]", trajectory.joint_position, (limits.joint_min, limits.joint_max)),
        ("speed [rad/s]", trajectory.joint_velocity, (-limits.speed, limits.speed)),
        ("acceleration [rad/s²]", trajectory.joint_acceleration, (-limits.acceleration, limits.acceleration)),
        (
            "torque estimate, without friction [N m]",
            torque_estimate(trajectory, rig),
            (-limits.torque, limits.torque),
        ),
    )
    for row, (label, values, bounds) in enumerate(rows):
        panel = figure.add_axes((0.56, 0.765 - 0.2335 * row, 0.425, 0.175))
        _draw_joints(panel, time, values[shown], label, bounds)
        panel.fill_between(time, *panel.get_ylim(), where=ramps.tolist(), color=RAMP, lw=0, zorder=0)
        if row < len(rows) - 1:
            panel.tick_params(labelbottom=False)
    figure.axes[-1].set_xlabel("time [s]")
    figure.legend(
        *panel.get_legend_handles_labels(), loc="upper right", bbox_to_anchor=(0.99, 1), ncols=3, frameon=False
    )
    return figure


def _draw_views(figure: Figure, platform: Floats, rate: float, limits: Limits) -> None:
    """Plot the path in space, from above and from the side, coloured by speed."""
    speed = np.linalg.norm(np.gradient(platform, 1 / rate, axis=0), axis=1)
    P = 1e3 * platform
    radius, (floor, ceiling) = 1e3 * limits.workspace_radius, (1e3 * z for z in limits.workspace_z)
    space: Any = figure.add_axes((-0.03, 0.35, 0.57, 0.56), projection="3d")
    _draw_space(space, P, speed, radius, (floor, ceiling))
    circle = radius * np.exp(1j * np.linspace(0, 2 * np.pi, 181))
    box = np.array([[-radius, floor], [radius, floor], [radius, ceiling], [-radius, ceiling], [-radius, floor]])
    outlines = (np.column_stack([circle.real, circle.imag]), box)
    for x_offset, vertical, title, outline in zip(
        (0.05, 0.29), (1, 2), ("from above", "from the side"), outlines, strict=True
    ):
        view = figure.add_axes((x_offset, 0.06, 0.17, 0.27))
        segments = list(_segments(P[:, [0, vertical]]))
        line = LineCollection(segments, array=speed[:-1], cmap=SPEED_COLOURS, lw=1.8, capstyle="round")
        view.add_collection(line)
        view.plot(*outline.T, color=QUIET, lw=0.8, ls="--")
        view.plot(P[0, 0], P[0, vertical], "o", color="black", ms=4)
        view.set_aspect("equal")
        view.set_title(title, fontsize=10, loc="left")
        view.set(xlabel="x [mm]", ylabel=f"{'xyz'[vertical]} [mm]")
        view.tick_params(labelsize=8)
    bar = figure.colorbar(line, cax=figure.add_axes((0.475, 0.1, 0.008, 0.19)))
    bar.ax.set_title("m/s", fontsize=9)
    bar.ax.tick_params(labelsize=8)


def _draw_space(axes: Any, P: Floats, speed: Floats, radius: float, z: tuple[float, float]) -> None:
    circle = np.linspace(0, 2 * np.pi, 121)
    for height in z:
        axes.plot(radius * np.cos(circle), radius * np.sin(circle), height, color=QUIET, lw=0.8, ls="--")
    axes.plot(P[:, 0], P[:, 1], z[0], color=SHADOW, lw=1)
    axes.add_collection(
        Line3DCollection(_segments(P), array=speed[:-1], cmap=SPEED_COLOURS, lw=2.4, capstyle="round")
    )
    axes.plot(*P[:1].T, "o", color="black", ms=5)
    axes.text(*P[0], "  start", fontsize=9)
    axes.set(xlim=(-radius, radius), ylim=(-radius, radius), zlim=z)
    axes.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
    axes.locator_params(nbins=5)
    axes.tick_params(labelsize=8)
    axes.set_box_aspect((2 * radius, 2 * radius, z[1] - z[0]), zoom=1.05)
    axes.view_init(elev=26, azim=-58)


def _segments(points: Floats) -> Floats:
    return np.stack([points[:-1], points[1:]], axis=1)


def _draw_joints(axes: Axes, time: Floats, values: Floats, label: str, bounds: tuple[float, float]) -> None:
    for joint, (colour, curve) in enumerate(zip(JOINTS, values.T, strict=False), start=1):
        axes.plot(time, curve, color=colour, lw=1.4, label=f"joint {joint}")
    low, high = float(values.min()), float(values.max())
    bottom, top = low - 0.1 * (high - low), high + 0.1 * (high - low)
    axes.set(xlim=(time[0], time[-1]), ylim=(bottom, top))
    for bound in bounds:
        # A distant limit would flatten the curves: draw a line only where it is in view; the title always states it.
        if bottom < bound < top:
            axes.axhline(bound, color=LIMIT, lw=1.2, ls="--")
    limit = f"±{bounds[1]:g}" if bounds[0] == -bounds[1] else f"{bounds[0]:g} to {bounds[1]:g}"
    axes.set_title(label, loc="left", fontsize=10)
    exceeded = low < bounds[0] or high > bounds[1]
    range_found = f"{low:.3g} to {high:.3g}, limit {limit}"
    axes.set_title(range_found, loc="right", fontsize=9, color=LIMIT if exceeded else QUIET)
    axes.grid(color="#E4E4E4", lw=0.6)
    axes.spines[["top", "right"]].set_visible(False)


def _caption(trajectory: Trajectory) -> str:
    duration = trajectory.time[-1]
    if not trajectory.period:
        return f"runs once, {duration:.2f} s at {trajectory.rate:g} Hz; shaded: soft start and end"
    return (
        f"the first of {trajectory.cycles} repetitions of {trajectory.period:g} s at {trajectory.rate:g} Hz, "
        f"{duration:.1f} s in all; shaded: soft start"
    )
