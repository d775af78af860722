"""The mission: fit, see the ladder, look what could be added, add it, watch the error fall."""

from nicegui import ui

from ident.workbench import plots
from ident.workbench.pages import branching, candidates, findings
from ident.workbench.pages.page import Page, set_test_id, draw_figure
from ident.workbench.views import LadderView, StepView


def draw(page: Page) -> None:
    """Everything about effects."""
    _buttons(page)
    page.draw_on_change(lambda: _draw_ladder(page), "ladder")
    page.draw_on_change(lambda: branching.draw(page), "ladder")
    page.draw_on_change(lambda: findings.draw(page), "answer")
    candidates.draw(page)


def _buttons(page: Page) -> None:
    session = page.session
    with ui.row().classes("items-center gap-2"):
        fit = ui.button("Fit", icon="play_arrow", on_click=page.handler(session.fit))
        fit.tooltip("Fit the base model, and what is true of any such machine")
        undo = ui.button("Undo", icon="undo", on_click=page.handler(session.undo)).props("outline")
        redo = ui.button("Redo", icon="redo", on_click=page.handler(session.redo)).props("outline")
        fork = ui.button("New branch", icon="call_split", on_click=page.handler(session.fork)).props("outline")
        fork.tooltip("Keep this ladder, and go on in a copy of it, to see two explanations side by side")
        full = ui.button("Full diagnosis", icon="biotech", on_click=page.handler(session.diagnose)).props("outline")
        full.tooltip("Let the program climb by itself, and question every finding: half a minute")
        for element, what in ((fit, "fit"), (undo, "undo"), (redo, "redo"), (fork, "fork"), (full, "diagnose")):
            set_test_id(element, what)
            element.props("no-caps")

    def allow() -> None:
        free = session.job is None or not session.job.blocking
        fit.enabled = free and session.train is not None
        present = session.branches.current if session.branches else None
        undo.enabled = free and present is not None and len(present.history) > 1
        redo.enabled = free and present is not None and bool(present.undone)
        fork.enabled = full.enabled = free and present is not None

    allow()
    page.call_on_change(allow, "job", "folder", "ladder")


def _draw_ladder(page: Page) -> None:
    session, ladder = page.session, page.session.ladder
    if ladder is None:
        ui.label(
            "Fit the base model to the recording: how much of the torque it explains is shown here, rung by rung, as "
            "effects are added. Choose a second recording with Check, to see whether it holds on another motion."
        ).classes("quiet")
        return
    draw_figure(plots.ladder(ladder), "error of each model, training and held out", session.dark)
    _draw_table(ladder)
    notes = [f"Held out: {ladder.held_out}. Noise floor: what a right model would leave, noise and encoder steps."]
    notes += ["Torques are relative: the gain is assumed."] if ladder.relative else []
    notes += [f"Of these long recordings {100 * ladder.excerpt:.0f} % was looked at."] if ladder.excerpt else []
    ui.label(" ".join(notes)).classes("quiet")
    _draw_terms(page, ladder.steps[-1])


def _draw_table(ladder: LadderView) -> None:
    joints = range(len(ladder.joints))
    unit = ladder.units[0]
    with ui.element("table").classes("figures ladder"):
        with ui.element("tr"):
            titles = [f"training j{j + 1} [{unit}]" for j in joints] + [f"held out j{j + 1} [{unit}]" for j in joints]
            for title in ("model", *titles, "gain on held out"):
                with ui.element("th"):
                    ui.label(title)
        for number, rung in enumerate(ladder.steps):
            with ui.element("tr"):
                with ui.element("td"):
                    set_test_id(ui.label(f"{number}  {rung.label}"), f"rung-{number}")
                for kind, values in (("train", rung.entry.train_rms), ("held", rung.entry.validate_rms)):
                    for j in joints:
                        with ui.element("td"):
                            set_test_id(ui.label(f"{values[j]:.4f}"), f"{kind}-{number}-{j + 1}")
                with ui.element("td"):
                    ui.label(_improvement(rung))


def _improvement(step: StepView) -> str:
    if step.improvement is None or step.improvement_ci95 is None:
        return ""
    gain, low, high = (round(100 * share) for share in (step.improvement, *step.improvement_ci95))
    return f"{gain} % ({low} to {high})"


def _draw_terms(page: Page, step: StepView) -> None:
    if not step.terms:
        return
    with ui.row().classes("items-center gap-2 q-mt-xs"):
        ui.label("In the model:")
        for index, (effect, joints) in enumerate(step.terms):
            with ui.row().classes("items-center no-wrap gap-1 chip"):
                ui.label(f"{effect}{_joints_note(joints, step)}")
                remove = ui.button("Remove", on_click=page.handler(page.session.remove, index))
                remove.props(f'flat dense size=sm no-caps aria-label="Remove {effect}"')
                set_test_id(remove, f"remove-{effect}")


def _joints_note(joints: tuple[int, ...], step: StepView) -> str:
    whole = len(joints) == len(step.entry.train_rms)
    return "" if whole else f" (joint {', '.join(map(str, joints))})"
