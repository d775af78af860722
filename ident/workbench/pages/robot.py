"""3D view of the robot at one instant, with the limbs coloured by their torque residual."""

import numpy as np
from nicegui import ui

from ident.output.poses import STEP, PoseSequence, pose_sequence
from ident.workbench.pages.page import Page, heading, quiet, set_test_id
from ident.workbench.worker.views import StepsView
from recordings.rig import Geometry

_LIFT = np.array([0.0, 0.0, 1.0])
"""Offset of the base above the ground of the scene, because the robot hangs [m]."""
_ROD_SPACING = 0.07
"""Distance between the two rods of a limb; no rig file states it, and no torque depends on it [m]."""
_NAME_OFFSET = 0.35
"""Distance of the name of a joint beyond its elbow, as a share of the arm's length."""


def draw(page: Page) -> None:
    """Draw the robot of the selected recording."""
    session, selection = page.session, page.session.selection
    view = session.recordings.shown
    if view is None or view.geometry is None:
        quiet("Choose a recording of a delta robot with Train in the list.")
        return
    series = next((series for series in selection.analysis.series if series.name == view.name), None)
    made = selection.steps if series else None
    poses = pose_sequence(
        view.geometry, view.time, view.signals["position"][1], series, made.noise_rms if made else (None, None, None)
    )
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
        _show_residuals(column, poses, slider.value, made)

    slider.on_value_change(update)

    def advance() -> None:
        slider.value = (slider.value + 1) % len(poses.time)

    timer = ui.timer(STEP, advance, active=False)
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


def _show_residuals(column: ui.column, poses: PoseSequence, i: int, made: StepsView | None) -> None:
    column.clear()
    with column:
        if made is None:
            quiet("Fit a model to see the torque residual of each limb.")
            return
        heading("Residual of each limb")
        for joint, (residual, unit) in enumerate(zip(poses.residual[i], made.units, strict=True), start=1):
            value = f"{residual:+.3f} {unit}" if np.isfinite(residual) else "not scored here"
            ui.label(f"joint {joint}: {value}")
        quiet("Grey: as small as noise. Orange: large residual.")
