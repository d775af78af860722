"""Stepwise selection: list of steps of models, branches, findings of the full diagnosis, candidate effects."""

from operator import methodcaller
from typing import Any

from nicegui import ui

from ident.diagnosis.judge.improvement import Improvement
from ident.workbench.pages import candidates, plots
from ident.workbench.pages.page import Cell, Page, draw_table, heading, notify, quiet, say_what_to_do, set_test_id
from ident.workbench.state.branches import Branches
from ident.workbench.worker.views import StepsView, StepView


def draw(page: Page) -> None:
    """Draw the buttons, the step_list, the findings, the candidates, and the errors of all models."""
    _buttons(page)
    page.draw_on_change(_draw_steps, "step_list")
    page.draw_on_change(_draw_diagnosis, "diagnosis")
    candidates.draw(page)
    page.draw_on_change(_draw_errors, "step_list")


def _buttons(page: Page) -> None:
    session, selection = page.session, page.session.selection
    with ui.row().classes("items-center gap-2"):
        undo = page.button("Undo", "undo", selection.change, Branches.undone, icon="undo", props="outline")
        redo = page.button("Redo", "redo", selection.change, Branches.redone, icon="redo", props="outline")
        fork = page.button(
            "New branch", "fork", selection.change, Branches.forked, icon="call_split", props="outline"
        )
        fork.tooltip("Keep this step_list and continue in a copy, to compare two models")
        full = page.button(
            "Full diagnosis", "diagnose", selection.extend, "diagnose", icon="biotech", props="outline"
        )
        full.tooltip("Automatic stepwise selection with a check of every finding; takes about half a minute")

    def update_enabled(page: Page) -> None:
        branch = selection.branches.current if selection.branches and not session.jobs.blocked else None
        undo.enabled = branch is not None and branch.can_undo
        redo.enabled = branch is not None and bool(branch.undone)
        fork.enabled = full.enabled = branch is not None

    page.watch(update_enabled, "job", "step_list")


def _draw_steps(page: Page) -> None:
    step_list = page.session.selection.step_list
    if step_list is None:
        say_what_to_do(
            page,
            "Each added effect is shown here as a step, with the error of every joint. Choose a second recording "
            "with Validate to validate the models on another motion.",
        )
        return
    joints = [f"j{joint} [{unit}]" for joint, unit in enumerate(step_list.units, start=1)]
    errors = [f"{kind} {joint}" for kind in ("training", "held out") for joint in joints]
    rows = (_row(number, step) for number, step in enumerate(step_list.steps))
    draw_table(["model", *errors, "improvement, held out"], rows, classes="step_list")
    relative = " Torques are relative: the gain is assumed." if step_list.relative else ""
    excerpt = f" {100 * step_list.excerpt:.0f} % of these long recordings was analysed." if step_list.excerpt else ""
    quiet(
        f"Held out: {step_list.held_out}. Noise floor: what a correct model leaves, by noise and encoder resolution."
        f"{relative}{excerpt}"
    )
    _draw_terms(page, step_list)


def _row(number: int, step: StepView) -> list[Cell]:
    def cell(text: str, test_id: str) -> Cell:
        return lambda: set_test_id(ui.label(text), test_id)

    cells = [cell(f"{number}  {step.label}", f"step-{number}")]
    for kind, values in {"train": step.entry.train_rms, "held": step.entry.held_out_rms}.items():
        cells += [cell(f"{value:.4f}", f"{kind}-{number}-{joint}") for joint, value in enumerate(values, start=1)]
    if step.improvement is None:
        return [*cells, ""]
    return [*cells, improvement_text(step.improvement)]


def improvement_text(improvement: Improvement) -> str:
    """Return the share with its interval in per cent."""
    share, low, high = (round(100 * value) for value in (improvement.share, *improvement.interval))
    return f"{share} % ({low} to {high})" if low < 100 else "over 99 %"


def _draw_terms(page: Page, step_list: StepsView) -> None:
    step = step_list.steps[-1]
    if step.refusal:
        set_test_id(ui.label(f"The data do not support the last effect: {step.refusal}."), "refusal")
    if not step.terms:
        return
    with ui.row().classes("items-center gap-2 q-mt-xs"):
        ui.label("In the model:")
        for index, (effect, joints) in enumerate(step.terms):
            note = "" if len(joints) == len(step_list.units) else f" (joint {', '.join(map(str, joints))})"
            with ui.row().classes("items-center no-wrap gap-1 chip"):
                ui.label(f"{effect}{note}")
                remove = (page.session.selection.extend, "remove", index)
                page.button("Remove", f"remove-{effect}", *remove, props="flat dense", label=f"Remove {effect}")


def _draw_errors(page: Page) -> None:
    """Draw the errors of the steps, and the branches with theirs if there is more than one."""
    selection = page.session.selection
    branches = selection.branches
    if branches is None:
        return
    page.draw_figure(plots.step_list(branches.current.step_list), "error of each model, training and held out")
    if len(branches.all) == 1:
        return
    heading("Branches", "q-mt-sm")
    page.draw_figure(plots.branches(branches.all), "error of each branch, training and held out")
    with ui.row().classes("items-center gap-2"):
        for index, branch in enumerate(branches.all):
            note = " (current)" if index == branches.index else ""
            with ui.row().classes("items-center no-wrap gap-1 chip"):
                set_test_id(ui.label(branch.title + note), f"branch-{branch.name}")
                actions = {"Switch to": "switched", "Drop": "dropped"} if not note else {}
                for label, action in actions.items():
                    word, change = label.split()[0], (selection.change, methodcaller(action, index))
                    name = f"{label} branch {branch.name}"
                    page.button(word, f"{word.lower()}-{branch.name}", *change, props="flat dense", label=name)


def _draw_diagnosis(page: Page) -> None:
    """Draw the findings of the full diagnosis with their evidence, if there is one."""
    diagnosis, library = page.session.selection.diagnosis, page.session.library
    if diagnosis is None:
        return
    document = diagnosis.document
    heading("Full diagnosis", "q-mt-sm")
    set_test_id(ui.label(document["sentence"]), "verdict")
    new_findings = [n for n, finding in enumerate(document["findings"]) if not library[finding["effect"]].mandatory]
    for number, finding in enumerate(document["findings"]):
        with ui.expansion(value=number in new_findings[:1]).classes("w-full") as box:
            _draw_finding(finding, number)
            figure = diagnosis.figures.get(finding["effect"])
            if figure:
                page.draw_figure(figure, f"residual without and with {finding['effect']}")
        with box.add_slot("header"), ui.row().classes("w-full items-center gap-3"):
            set_test_id(ui.label(finding["effect"]).classes("font-medium"), f"finding-{number}")
            quiet(f"joint {', '.join(map(str, finding['joints']))}")
            if finding["share"] is not None:
                ui.label(f"{100 * finding['share']:.0f} % of the first model's held-out error above the noise floor")
    for likely in document["likely"]:
        ui.label(f"Likely: {likely['effect']} (joint {', '.join(map(str, likely['joints']))}). {likely['why']}")
    remaining, motion = document["remaining"], document["next_motion"]
    if remaining["why"]:
        share = 100 * remaining["structured_share"]
        structured = f"{share:.0f} % of it is structured; " if document["verdict"] == "unknown-structure" else ""
        quiet(f"Unexplained residual: {structured}{remaining['why']}")
    if remaining["formula"]:
        _draw_formula(page, remaining["formula"], diagnosis.law or "")
    if motion:
        quiet(f"Record next: {motion['why']} {motion['command']}")
    with ui.expansion("Rejected effects").classes("w-full"):
        for candidate in document["rejected"]:
            ui.label(f"{candidate['effect']}: {candidate['why']}").classes("text-sm")


def _draw_formula(page: Page, formula: dict[str, Any], law: str) -> None:
    """Draw a formula for what is left, and the button that writes the effect file `law` with it."""
    joints = ", ".join(map(str, formula["joints"]))
    with ui.row().classes("items-center gap-3"):
        set_test_id(ui.label(f"A formula for it, on joint {joints}: {formula['text']}"), "formula")
        page.button(
            "write it as an effect file", "write-formula", _write_formula, page, law, props="flat dense no-wrap"
        )
    values = ", ".join(
        f"{name} = {parameter['value']:.4g} {parameter['unit']}" for name, parameter in formula["parameters"].items()
    )
    others = "; ".join(formula["alternatives"])
    quiet(
        f"{values}. It takes {100 * formula['explains']:.0f} % of the held-out mean square above the noise floor. "
        f"Known for {formula['known_for']}.{f' These data cannot tell it from: {others}.' if others else ''}"
    )


def _write_formula(page: Page, law: str) -> None:
    folder = page.session.folder
    path = folder.new_file(folder.free_name("law", ".py"), ".py")
    path.write_text(law, encoding="utf-8")
    notify(
        f"{path.name} written. To use it: ident effects --adopt {path.name}, and start the workbench again",
        "positive",
    )


def _draw_finding(finding: dict[str, Any], number: int) -> None:
    others = ", ".join(finding["confusable_with"]) or "no other effect of the library on these data"
    for label, text in {
        "Effect": finding["sentence"],
        "Evidence": finding["why"],
        "Symptom": finding["symptom"],
        "Usual causes": finding["causes"],
        "Remedy": finding["remedy"],
        "Confusable with": others,
    }.items():
        with ui.row().classes("no-wrap gap-3 q-py-xs"):
            quiet(label).classes("w-32 shrink-0")
            set_test_id(ui.label(text), f"finding-{number}-{label.lower().replace(' ', '-')}")
