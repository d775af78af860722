"""Stepwise selection: fit, list of steps of models, candidate effects, findings."""

from nicegui import ui

from ident.workbench import plots
from ident.workbench.pages import branching, candidates, findings
from ident.workbench.pages.page import Cell, Page, draw_table, set_test_id
from ident.workbench.views import StepsView, StepView


def draw(page: Page) -> None:
    """Draw the buttons, the step_list, the branches, the findings and the candidates."""
    _buttons(page)
    page.draw_on_change(_draw_steps, "step_list")
    page.draw_on_change(branching.draw, "step_list")
    page.draw_on_change(findings.draw, "diagnosis")
    candidates.draw(page)


def _buttons(page: Page) -> None:
    session, selection = page.session, page.session.selection
    with ui.row().classes("items-center gap-2"):
        undo = page.button("Undo", "undo", selection.undo, icon="undo", props="outline")
        redo = page.button("Redo", "redo", selection.redo, icon="redo", props="outline")
        fork = page.button("New branch", "fork", selection.fork, icon="call_split", props="outline")
        fork.tooltip("Keep this step_list and continue in a copy, to compare two models")
        full = page.button("Full diagnosis", "diagnose", selection.diagnose, icon="biotech", props="outline")
        full.tooltip("Automatic stepwise selection with a check of every finding; takes about half a minute")

    def update_enabled(page: Page) -> None:
        idle = not session.jobs.blocked
        branch = selection.branches.current if selection.branches and idle else None
        undo.enabled = branch is not None and len(branch.history) > 1
        redo.enabled = branch is not None and bool(branch.undone)
        fork.enabled = full.enabled = branch is not None

    page.call_now_and_on_change(update_enabled, "job", "step_list")


def _draw_steps(page: Page) -> None:
    step_list = page.session.selection.step_list
    if step_list is None:
        ui.label(
            "Press Fit to fit the base model to the recording. Each added effect is shown here as a step, with the "
            "error of every joint. Choose a second recording with Validate to validate the models on another motion."
        ).classes("quiet")
        return
    page.draw_figure(plots.step_list(step_list), "error of each model, training and held out")
    _draw_table(step_list)
    relative = " Torques are relative: the gain is assumed." if step_list.relative else ""
    excerpt = f" {100 * step_list.excerpt:.0f} % of these long recordings was analysed." if step_list.excerpt else ""
    ui.label(
        f"Held out: {step_list.held_out}. Noise floor: what a correct model leaves, by noise and encoder resolution."
        f"{relative}{excerpt}"
    ).classes("quiet")
    _draw_terms(page, step_list.steps[-1])


def _draw_table(step_list: StepsView) -> None:
    joints = [f"j{joint} [{unit}]" for joint, unit in enumerate(step_list.units, start=1)]
    errors = [f"{kind} {joint}" for kind in ("training", "held out") for joint in joints]
    rows = (_row(number, step) for number, step in enumerate(step_list.steps))
    draw_table(["model", *errors, "improvement, held out"], rows, classes="step_list")


def _row(number: int, step: StepView) -> list[Cell]:
    def cell(text: str, test_id: str) -> Cell:
        return lambda: set_test_id(ui.label(text), test_id)

    errors = {"train": step.entry.train_rms, "held": step.entry.held_out_rms}
    return [
        cell(f"{number}  {step.label}", f"step-{number}"),
        *(
            cell(f"{value:.4f}", f"{kind}-{number}-{joint}")
            for kind, values in errors.items()
            for joint, value in enumerate(values, start=1)
        ),
        _improvement(step),
    ]


def _improvement(step: StepView) -> str:
    if step.improvement is None or step.improvement_ci95 is None:
        return ""
    improvement, low, high = (round(100 * share) for share in (step.improvement, *step.improvement_ci95))
    return f"{improvement} % ({low} to {high})"


def _draw_terms(page: Page, step: StepView) -> None:
    if step.refusal:
        set_test_id(ui.label(f"The data do not support the last effect: {step.refusal}."), "refusal")
    if not step.terms:
        return
    with ui.row().classes("items-center gap-2 q-mt-xs"):
        ui.label("In the model:")
        for index, (effect, joints) in enumerate(step.terms):
            all_joints = len(joints) == len(step.entry.train_rms)
            note = "" if all_joints else f" (joint {', '.join(map(str, joints))})"
            with ui.row().classes("items-center no-wrap gap-1 chip"):
                ui.label(f"{effect}{note}")
                props = f'flat dense aria-label="Remove {effect}"'
                page.button("Remove", f"remove-{effect}", page.session.selection.remove, index, props=props)
