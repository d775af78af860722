"""3D view of the robot at one instant, with the limbs coloured by their torque residual."""

import numpy as np
from nicegui import ui

from ident.workbench.pages.page import Page, set_test_id
from ident.workbench.pose import STEP, PoseSequence, pose_sequence
from ident.workbench.views import LadderView, TorqueSeries
from recordings.rig import Geometry

_LIFT = np.array([0.0, 0.0, 1.0])
"""Offset of the base above the ground of the scene, because the robot hangs [m]."""


def draw(page: Page) -> None:
    """Draw the robot of the selected recording."""
    session, selection = page.session, page.session.selection
    view = session.recordings.shown
    if view is None or view.geometry is None:
        ui.label("Choose a recording of a delta robot on the left.").classes("quiet")
        return
    series = next((series for series in selection.series if series.name == view.name), None)
    poses = pose_sequence(view, view.geometry, series)
    with ui.row().classes("w-full items-center no-wrap gap-4"):
        clock = ui.label().classes("w-20")
        slider = ui.slider(min=0, max=len(poses.time) - 1, value=0).props('aria-label="time"').classes("col")
        set_test_id(slider, "time")
        play = ui.button(icon="play_arrow").props('round flat aria-label="Play"')
    with ui.row().classes("w-full no-wrap items-start"):
        background = "#1d2226" if session.display.dark else "#f4f6f7"
        with ui.scene(width=760, height=470, grid=(2, 20), background_color=background) as scene:
            robot = _Scene(poses, view.geometry)
        scene.move_camera(x=0.95, y=-1.05, z=0.95, look_at_z=0.6, duration=0)
        column = ui.column().classes("gap-1")

    def update() -> None:
        robot.move(slider.value)
        clock.text = f"{poses.time[slider.value]:.2f} s"
        _show_residuals(column, series, selection.ladder, poses.time[slider.value])

    slider.on_value_change(update)
    timer = ui.timer(STEP, lambda: slider.set_value((slider.value + 1) % len(poses.time)), active=False)
    play.on_click(lambda: setattr(timer, "active", not timer.active))
    slider.value = len(poses.time) // 3  # in the middle of the motion there is something to see
    update()


class _Scene:
    """Base, arms, forearms and platform in the 3D scene."""

    def __init__(self, poses: PoseSequence, geometry: Geometry) -> None:
        from nicegui.elements.scene import Scene

        self._poses = poses
        Scene.cylinder(geometry.R, geometry.R, 0.02, 48).rotate(1.5708, 0, 0).move(*_LIFT).material("#7b858d")
        self._platform = Scene.cylinder(geometry.r, geometry.r, 0.015, 32).rotate(1.5708, 0, 0).material("#7b858d")
        self._arms = [Scene.cylinder(0.016, 0.016, geometry.L1, 16) for _ in range(3)]
        self._rods = [Scene.cylinder(0.008, 0.008, geometry.L2, 12) for _ in range(3)]

    def move(self, i: int) -> None:
        """Move all bodies to their pose at the instant `i`."""
        poses = self._poses
        self._platform.move(*(poses.platform[i] + _LIFT))
        for limb in range(3):
            colour = poses.colour(i, limb)
            for body, start, end in (
                (self._arms[limb], poses.shoulders[limb], poses.elbows[i, limb]),
                (self._rods[limb], poses.elbows[i, limb], poses.platform_joints[i, limb]),
            ):
                body.move(*((start + end) / 2 + _LIFT)).rotate_R(poses.cylinder_rotation(start, end)).material(colour)


def _show_residuals(column: ui.column, series: TorqueSeries | None, ladder: LadderView | None, time: float) -> None:
    column.clear()
    with column:
        if series is None or ladder is None:
            ui.label("Fit a model to see the torque residual of each limb.").classes("quiet")
            return
        row = int(abs(series.time - time).argmin())
        ui.label("Residual of each limb").classes("head")
        for joint, (residual, unit) in enumerate(zip(series.residual[row], ladder.units, strict=True), start=1):
            ui.label(
                f"joint {joint}: {residual:+.3f} {unit}"
                if np.isfinite(residual)
                else f"joint {joint}: not scored here"
            )
        ui.label("Grey: small residual. Orange: large residual.").classes("quiet")
