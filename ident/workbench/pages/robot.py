"""The robot in 3D at one instant, its limbs coloured by what the model leaves of their torque."""

import numpy as np
from nicegui import ui

from ident.workbench.pages.page import Page, set_test_id
from ident.workbench.pose import PoseSequence, pose_sequence
from ident.workbench.views import TorqueSeries

_LIFT = np.array([0.0, 0.0, 1.0])
"""The robot hangs; the ground of the scene is at 0 [m]."""


def draw(page: Page) -> None:
    """The present model's recording, or else the one that was opened."""
    page.draw_on_change(lambda: _draw(page), "series", "recording")


def _draw(page: Page) -> None:
    session = page.session
    view = session.recording
    if view is None or view.geometry is None:
        ui.label("Choose a recording of a delta robot on the left.").classes("quiet")
        return
    series = next((one for one in session.series if one.name == view.name), None)
    moving = pose_sequence(view, series)
    with ui.row().classes("w-full items-center no-wrap gap-4"):
        clock = ui.label().classes("w-20")
        slider = ui.slider(min=0, max=len(moving.time) - 1, value=0).classes("col")
        slider.props('aria-label="time"')
        set_test_id(slider, "time")
        play = ui.button(icon="play_arrow").props('round flat aria-label="Play"')
    with ui.row().classes("w-full no-wrap items-start"):
        background = "#1d2226" if session.dark else "#f4f6f7"
        with ui.scene(width=760, height=470, grid=(2, 20), background_color=background) as scene:
            bodies = _Scene(moving)
        scene.move_camera(x=0.95, y=-1.05, z=0.95, look_at_z=0.6, duration=0)
        told = ui.column().classes("gap-1")

    def at() -> None:
        bodies.move(slider.value)
        clock.text = f"{moving.time[slider.value]:.2f} s"
        units = session.ladder.units if session.ladder else ()
        _show_residuals(told, series, units, moving.time[slider.value])

    def step() -> None:
        slider.value = (slider.value + 1) % len(moving.time)

    slider.on_value_change(at)
    timer = ui.timer(moving.step, step, active=False)
    play.on_click(lambda: setattr(timer, "active", not timer.active))
    slider.value = len(moving.time) // 3  # in the middle of the motion there is something to see
    at()


class _Scene:
    """Base, arms, forearms and platform in the scene."""

    def __init__(self, poses: PoseSequence) -> None:
        from nicegui.elements.scene import Scene

        self._poses = poses
        geometry = poses.geometry
        Scene.cylinder(geometry.R, geometry.R, 0.02, 48).rotate(1.5708, 0, 0).move(*_LIFT).material("#7b858d")
        self._platform = Scene.cylinder(geometry.r, geometry.r, 0.015, 32).rotate(1.5708, 0, 0).material("#7b858d")
        self._arms = [Scene.cylinder(0.016, 0.016, geometry.L1, 16) for _ in range(3)]
        self._rods = [Scene.cylinder(0.008, 0.008, geometry.L2, 12) for _ in range(3)]

    def move(self, i: int) -> None:
        """To the instant `i`."""
        moving = self._poses
        self._platform.move(*(moving.platform[i] + _LIFT))
        for limb in range(3):
            colour = moving.colour(i, limb)
            for body, start, end in (
                (self._arms[limb], moving.shoulders[limb], moving.elbows[i, limb]),
                (self._rods[limb], moving.elbows[i, limb], moving.platform_joints[i, limb]),
            ):
                body.move(*((start + end) / 2 + _LIFT)).rotate_R(moving.cylinder_rotation(start, end)).material(colour)


def _show_residuals(column: ui.column, series: TorqueSeries | None, units: tuple[str, ...], time: float) -> None:
    column.clear()
    with column:
        if series is None:
            ui.label("Fit a model to see what is left of each limb's torque.").classes("quiet")
            return
        at = int(abs(series.time - time).argmin())
        ui.label("Residual of each limb").classes("head")
        for joint, (left, unit) in enumerate(zip(series.residual[at], units, strict=True), start=1):
            ui.label(f"joint {joint}: {left:+.3f} {unit}" if np.isfinite(left) else f"joint {joint}: not judged here")
        ui.label("Grey: as small as usual. Orange: the largest there is.").classes("quiet")
