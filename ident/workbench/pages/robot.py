"""3D view of the robot at one instant, with the limbs coloured by their torque residual."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from nicegui import ui
from scipy.spatial.transform import Rotation

from ident.basics.statistics import TINY
from ident.workbench.pages.page import Page, heading, quiet, set_test_id
from ident.workbench.worker.views import RecordingView, StepsView, TorqueSeries
from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories import kinematics

_STEP = 0.05
"""Time between two poses [s]."""
_NOISE_FLOORS = 3.0
"""Noise floors up to which noise explains a residual, and, doubled, the least that has the colour of a large one."""
_SMALL_RESIDUAL_COLOUR, _LARGE_RESIDUAL_COLOUR = (138, 148, 156), (213, 94, 0)
"""RGB colours of a limb with the smallest and the largest residual."""
_LIFT = np.array([0.0, 0.0, 1.0])
"""Offset of the base above the ground of the scene, because the robot hangs [m]."""
_ROD_SPACING = 0.07
"""Distance between the two rods of a limb; no rig file states it, and no torque depends on it [m]."""
_NAME_OFFSET = 0.35
"""Distance of the name of a joint beyond its elbow, as a share of the arm's length."""


@dataclass(frozen=True, eq=False)
class PoseSequence:
    """Poses of the three limbs at n instants."""

    time: Floats
    """[s]."""
    platform: Floats
    """(n, 3) [m]."""
    shoulders: Floats
    """(3 limbs, 3) [m]."""
    elbows: Floats
    """(n, 3 limbs, 3) [m]."""
    platform_joints: Floats
    """(n, 3 limbs, 3) joints between forearms and platform [m]."""
    tangents: Floats
    """(3 limbs, 3) unit vectors along the axes of the shoulders."""
    residual: Floats
    """(n, 3 limbs); NaN where it is not scored."""
    small: Floats
    """(3 limbs) largest residual that noise explains; the colour of the limb does not change below."""
    large: float
    """Residual above which the colour does not change any more."""

    def colour(self, i: int, limb: int) -> str:
        """Return the colour of `limb` (from 0) at the instant `i`."""
        residual, small = np.nan_to_num(abs(self.residual[i, limb])), self.small[limb]
        share = float(np.clip((residual - small) / max(self.large - small, TINY), 0.0, 1.0))
        return "#" + "".join(
            f"{round(a + share * (b - a)):02x}"
            for a, b in zip(_SMALL_RESIDUAL_COLOUR, _LARGE_RESIDUAL_COLOUR, strict=True)
        )

    @staticmethod
    def cylinder_rotation(start: Floats, end: Floats) -> list[list[float]]:
        """Return the rotation matrix that turns a cylinder along y into the direction from `start` to `end` (3,)."""
        rotation, _ = Rotation.align_vectors(end - start, [0.0, 1.0, 0.0])
        return rotation.as_matrix().tolist()


def draw(page: Page) -> None:
    """Draw the robot of the selected recording."""
    session, selection = page.session, page.session.selection
    view = session.recordings.shown
    if view is None or view.geometry is None:
        quiet("Choose a recording of a delta robot with Train in the list.")
        return
    series = next((series for series in selection.analysis.series if series.name == view.name), None)
    step_list = selection.step_list if series else None
    poses = pose_sequence(view, view.geometry, series, step_list.noise_rms if step_list else (None, None, None))
    with ui.row().classes("w-full items-center no-wrap gap-4"):
        clock = ui.label().classes("w-20")
        slider = ui.slider(min=0, max=len(poses.time) - 1, value=0).props('aria-label="time"').classes("col")
        set_test_id(slider, "time")
        play = ui.button(icon="play_arrow").props('round flat aria-label="Play"')
    with ui.element("div").classes("beside"):
        background = "#1d2226" if session.display.dark else "#f4f6f7"
        with ui.scene(width=760, height=470, grid=(2, 20), background_color=background).classes("robot") as scene:
            robot = _Scene(scene, poses, view.geometry, "#8cc8f2" if session.display.dark else "#0b5c8c")
        scene.on("init", lambda: ui.run_javascript(f"drawOnlyWhileShown(getElement({scene.id}))"))
        scene.move_camera(x=0.95, y=-1.05, z=0.95, look_at_z=0.6, duration=0)
        column = ui.column().classes("gap-1")

    def update() -> None:
        robot.move(slider.value)
        clock.text = f"{poses.time[slider.value]:.2f} s"
        _show_residuals(column, poses, slider.value, step_list)

    slider.on_value_change(update)

    def advance() -> None:
        if page.visible_tab == "robot":
            slider.value = (slider.value + 1) % len(poses.time)

    timer = ui.timer(_STEP, advance, active=False)
    play.on_click(lambda: setattr(timer, "active", not timer.active))
    slider.value = len(poses.time) // 3  # in the middle of the motion there is something to see
    update()


class _Scene:
    """Base, arms, forearms and platform in the 3D scene."""

    def __init__(self, scene: ui.scene, poses: PoseSequence, geometry: Geometry, name_colour: str) -> None:
        self._poses = poses
        scene.cylinder(geometry.R, geometry.R, 0.02, 48).rotate(1.5708, 0, 0).move(*_LIFT).material("#7b858d")
        self._platform = scene.cylinder(geometry.r, geometry.r, 0.015, 32).rotate(1.5708, 0, 0).material("#7b858d")
        self._arms = [scene.cylinder(0.016, 0.016, geometry.L1, 16) for _ in range(3)]
        self._rods = [[scene.cylinder(0.006, 0.006, geometry.L2, 12) for _ in (-1, 1)] for _ in range(3)]
        self._names = [scene.text(f"joint {limb + 1}", f"font-size: 14px; color: {name_colour}") for limb in range(3)]

    def move(self, i: int) -> None:
        """Move all bodies to their pose at the instant `i`."""
        poses = self._poses
        self._platform.move(*(poses.platform[i] + _LIFT))
        for limb in range(3):
            colour = poses.colour(i, limb)
            elbow, half = poses.elbows[i, limb], _ROD_SPACING / 2 * poses.tangents[limb]
            joint = poses.platform_joints[i, limb]
            self._names[limb].move(*(elbow + _NAME_OFFSET * (elbow - poses.shoulders[limb]) + _LIFT))
            for body, start, end in (
                (self._arms[limb], poses.shoulders[limb], elbow),
                (self._rods[limb][0], elbow - half, joint - half),
                (self._rods[limb][1], elbow + half, joint + half),
            ):
                body.move(*((start + end) / 2 + _LIFT)).rotate_R(poses.cylinder_rotation(start, end)).material(colour)


def _show_residuals(column: ui.column, poses: PoseSequence, i: int, step_list: StepsView | None) -> None:
    column.clear()
    with column:
        if step_list is None:
            quiet("Fit a model to see the torque residual of each limb.")
            return
        heading("Residual of each limb")
        for joint, (residual, unit) in enumerate(zip(poses.residual[i], step_list.units, strict=True), start=1):
            value = f"{residual:+.3f} {unit}" if np.isfinite(residual) else "not scored here"
            ui.label(f"joint {joint}: {value}")
        quiet("Grey: as small as noise. Orange: large residual.")


def pose_sequence(
    view: RecordingView,
    geometry: Geometry,
    series: TorqueSeries | None,
    noise_rms: Sequence[float | None] = (None, None, None),
) -> PoseSequence:
    """Compute the poses of the delta robot in `view`; `series` gives the residuals that colour the limbs, compared
    with the noise floors `noise_rms` if they are known."""
    position = view.signals["position"][1].astype(float)
    valid_rows = np.flatnonzero(np.isfinite(position).all(axis=1))
    sample_times = np.arange(view.time[valid_rows[0]], view.time[valid_rows[-1]], _STEP)
    rows = valid_rows[np.minimum(np.searchsorted(view.time[valid_rows], sample_times), len(valid_rows) - 1)]
    theta = position[rows]
    platform = kinematics.forward(geometry, theta)
    phi = np.array(geometry.phi)
    directions = np.stack([np.cos(phi), np.sin(phi), np.zeros(3)], axis=1)
    tangents = np.stack([-np.sin(phi), np.cos(phi), np.zeros(3)], axis=1)
    elbows = (geometry.R + geometry.L1 * np.cos(theta))[:, :, None] * directions
    elbows[:, :, 2] = geometry.L1 * np.sin(theta)
    small = _NOISE_FLOORS * np.array([noise or 0.0 for noise in noise_rms])
    residual = _residual_at(series, view.time[rows])
    large = 0.0 if series is None else float(np.nanquantile(np.abs(series.residual), 0.98))
    return PoseSequence(
        time=view.time[rows],
        platform=platform,
        shoulders=geometry.R * directions,
        elbows=elbows,
        platform_joints=platform[:, None, :] + geometry.r * directions,
        tangents=tangents,
        residual=residual,
        small=small,
        large=max(large, 2 * small.max()),
    )


def _residual_at(series: TorqueSeries | None, time: Floats) -> Floats:
    """Return the residuals (n, 3) at the rows nearest to `time` (n,)."""
    if series is None:
        return np.full((len(time), 3), np.nan)
    after = np.clip(np.searchsorted(series.time, time), 1, len(series.time) - 1)
    nearest = after - (time - series.time[after - 1] < series.time[after] - time)
    return series.residual[nearest]
