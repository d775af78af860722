"""Stepwise selection: fit, ladder of models, candidate effects, findings."""

from nicegui import ui

from ident.workbench import plots
from ident.workbench.pages import branching, candidates, findings
from ident.workbench.pages.page import Page, draw_figure, set_test_id
from ident.workbench.views import LadderView, StepView


def draw(page: Page) -> None:
    """Draw the buttons, the ladder, the branches, the findings and the candidates."""
    _buttons(page)
    page.draw_on_change(lambda: _draw_ladder(page), "ladder")
    page.draw_on_change(lambda: branching.draw(page), "ladder")
    page.draw_on_change(lambda: findings.draw(page), "diagnosis")
    candidates.draw(page)


def _buttons(page: Page) -> None:
    session = page.session
    with ui.row().classes("items-center gap-2"):
        fit = ui.button("Fit", icon="play_arrow", on_click=page.handler(session.fit))
        fit.tooltip("Fit the base model with the mandatory effects")
        undo = ui.button("Undo", icon="undo", on_click=page.handler(session.undo)).props("outline")
        redo = ui.button("Redo", icon="redo", on_click=page.handler(session.redo)).props("outline")
        fork = ui.button("New branch", icon="call_split", on_click=page.handler(session.fork)).props("outline")
        fork.tooltip("Keep this ladder and continue in a copy, to compare two models")
        full = ui.button("Full diagnosis", icon="biotech", on_click=page.handler(session.diagnose)).props("outline")
        full.tooltip("Automatic stepwise selection with a check of every finding; takes about half a minute")
        for element, test_id in ((fit, "fit"), (undo, "undo"), (redo, "redo"), (fork, "fork"), (full, "diagnose")):
            set_test_id(element, test_id)
            element.props("no-caps")

    def update_enabled() -> None:
        idle = session.job is None or not session.job.blocking
        fit.enabled = idle and session.train is not None
        branch = session.branches.current if session.branches else None
        undo.enabled = idle and branch is not None and len(branch.history) > 1
        redo.enabled = idle and branch is not None and bool(branch.undone_ladders)
        fork.enabled = full.enabled = idle and branch is not None

    update_enabled()
    page.call_on_change(update_enabled, "job", "folder", "ladder")


def _draw_ladder(page: Page) -> None:
    session, ladder = page.session, page.session.ladder
    if ladder is None:
        ui.label(
            "Fit the base model to the recording. Each added effect is shown here as a step, with the error of every "
            "joint. Choose a second recording with Check to validate the models on another motion."
        ).classes("quiet")
        return
    draw_figure(plots.ladder(ladder), "error of each model, training and held out", session.dark)
    _draw_table(ladder)
    notes = [
        f"Held out: {ladder.held_out}. Noise floor: residual of a correct model, from noise and encoder resolution."
    ]
    notes += ["Torques are relative: the gain is assumed."] if ladder.relative else []
    notes += [f"{100 * ladder.excerpt:.0f} % of these long recordings was analysed."] if ladder.excerpt else []
    ui.label(" ".join(notes)).classes("quiet")
    _draw_terms(page, ladder.steps[-1])


def _draw_table(ladder: LadderView) -> None:
    joints = range(len(ladder.joints))
    unit = ladder.units[0]
    with ui.element("table").classes("figures ladder"):
        with ui.element("tr"):
            titles = [f"training j{j + 1} [{unit}]" for j in joints] + [f"held out j{j + 1} [{unit}]" for j in joints]
            for title in ("model", *titles, "improvement, held out"):
                with ui.element("th"):
                    ui.label(title)
        for number, step in enumerate(ladder.steps):
            with ui.element("tr"):
                with ui.element("td"):
                    set_test_id(ui.label(f"{number}  {step.label}"), f"step-{number}")
                for kind, values in (("train", step.entry.train_rms), ("held", step.entry.validate_rms)):
                    for j in joints:
                        with ui.element("td"):
                            set_test_id(ui.label(f"{values[j]:.4f}"), f"{kind}-{number}-{j + 1}")
                with ui.element("td"):
                    ui.label(_improvement(step))


def _improvement(step: StepView) -> str:
    if step.improvement is None or step.improvement_ci95 is None:
        return ""
    improvement, low, high = (round(100 * share) for share in (step.improvement, *step.improvement_ci95))
    return f"{improvement} % ({low} to {high})"


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
    all_joints = len(joints) == len(step.entry.train_rms)
    return "" if all_joints else f" (joint {', '.join(map(str, joints))})"
