"""Stepwise selection: steps from model to model, branches, findings of the full diagnosis, candidate effects."""

from collections.abc import Callable
from operator import attrgetter, methodcaller
from typing import Any

from nicegui import ui

from ident.diagnosis.judge.improvement import Improvement
from ident.output.figures import theme
from ident.output.figures.steps import rms_bars
from ident.workbench.figure import Figure, to_dict
from ident.workbench.pages import candidates
from ident.workbench.pages.page import Cell, Page, draw_table, heading, notify, quiet, say_what_to_do, set_test_id
from ident.workbench.state.history import History
from ident.workbench.worker.views import StepsView, StepView


def draw(page: Page) -> None:
    """Draw the buttons, the steps, the findings, the candidates, and the errors of all models."""
    _buttons(page)
    page.draw_on_change(_draw_steps, "steps")
    page.draw_on_change(_draw_findings, "diagnosis")
    candidates.draw(page)
    page.draw_on_change(_draw_errors, "steps")


def _buttons(page: Page) -> None:
    session, selection = page.session, page.session.selection
    with ui.row().classes("items-center gap-2"):
        undo = page.button("Undo", "undo", _go, page, attrgetter("undo"), icon="undo", props="outline")
        redo = page.button("Redo", "redo", _go, page, attrgetter("redo"), icon="redo", props="outline")
        full = page.button(
            "Full diagnosis", "diagnose", selection.extend, "diagnose", icon="biotech", props="outline"
        )
        full.tooltip("Automatic stepwise selection with a check of every finding; takes about half a minute")

    def update_enabled(page: Page) -> None:
        history = None if session.jobs.blocked else selection.history
        undo.enabled = history is not None and history.undo is not None
        redo.enabled = history is not None and history.redo is not None
        full.enabled = history is not None

    page.watch(update_enabled, "job", "steps")


def _go(page: Page, number: Callable[[History], int | None]) -> None:
    """Look at another model of the history."""
    page.session.selection.go(lambda history: history.at(number(history)))


def _draw_steps(page: Page) -> None:
    made = page.session.selection.steps
    if made is None:
        say_what_to_do(
            page,
            "Each added effect is shown here as a step, with the error of every joint. Choose a second recording "
            "with Validate to validate the models on another motion.",
        )
        return
    joints = [f"j{joint} [{unit}]" for joint, unit in enumerate(made.units, start=1)]
    errors = [f"{kind} {joint}" for kind in ("training", "held out") for joint in joints]
    rows = (_row(number, step) for number, step in enumerate(made.steps))
    draw_table(["model", *errors, "improvement, held out"], rows, classes="steps")
    relative = " Torques are relative: the gain is assumed." if made.relative else ""
    excerpt = f" {100 * made.excerpt:.0f} % of these long recordings was analysed." if made.excerpt else ""
    quiet(
        f"Held out: {made.held_out}. Noise floor: what a correct model leaves, by noise and encoder resolution. "
        "Improvement: share of the mean square above it that the row above leaves, on the joints that change."
        f"{relative}{excerpt}"
    )
    for warning in made.warnings:
        set_test_id(quiet(warning), "steps-warning")
    _draw_terms(page, made)


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
    """Return the share with its interval in per cent; without one that says no more, or nothing at all."""
    share, low, high = (round(100 * value) for value in (improvement.share, *improvement.interval))
    if low >= 100:
        return "over 99 %"
    if high - low >= 100:
        return f"{share} %, or none"
    return f"{share} %" if low == high else f"{share} % ({low} to {high})"


def _draw_terms(page: Page, made: StepsView) -> None:
    step = made.steps[-1]
    if step.refusal:
        set_test_id(ui.label(f"The data do not support the last effect: {step.refusal}."), "refusal")
    if not step.terms:
        return
    with ui.row().classes("items-center gap-2 q-mt-xs"):
        ui.label("In the model:")
        for index, (effect, joints) in enumerate(step.terms):
            note = "" if len(joints) == len(made.units) else f" (joint {', '.join(map(str, joints))})"
            with ui.row().classes("items-center no-wrap gap-1 chip"):
                ui.label(f"{effect}{note}")
                remove = (page.session.selection.extend, "remove", index)
                page.button("Remove", f"remove-{effect}", *remove, props="flat dense", label=f"Remove {effect}")


def _draw_errors(page: Page) -> None:
    """Draw the errors of the steps, and the branches with theirs if there is more than one."""
    history = page.session.selection.history
    if history is None:
        return
    page.draw_figure(steps_figure(history.made), "error of each model, training and held out")
    if len(history.ends) == 1:
        return
    heading("Branches", "q-mt-sm")
    quiet("What was tried after an undo stays here. Errors are of the rows that the last model can be judged by.")
    page.draw_figure(branches_figure(history), "error of each branch, training and held out")
    with ui.row().classes("items-center gap-2"):
        for end in history.ends:
            _draw_branch(page, history, end)


def _draw_branch(page: Page, history: History, end: int) -> None:
    title, current = history.title(end), end == history.end
    number = title.partition(":")[0]
    with ui.row().classes("items-center no-wrap gap-1 chip"):
        set_test_id(ui.label(f"{title}{' (current)' if current else ''}"), f"branch-{number}")
        if not current:
            label = f"Switch to branch {number}"
            page.button("Switch", f"switch-{number}", _go, page, lambda _: end, props="flat dense", label=label)
            drop = (page.session.selection.go, methodcaller("without", end))
            page.button("Drop", f"drop-{number}", *drop, props="flat dense", label=f"Drop branch {number}")


def _draw_findings(page: Page) -> None:
    """Draw the findings of the full diagnosis with their evidence, if it has found the current model."""
    made, library = page.session.selection.steps, page.session.library
    if made is None or made.findings is None:
        return
    document, figures = made.findings.document, page.session.selection.analysis.diagnosis
    heading("Full diagnosis", "q-mt-sm")
    set_test_id(ui.label(document["sentence"]), "verdict")
    new_findings = [n for n, finding in enumerate(document["findings"]) if not library[finding["effect"]].mandatory]
    for number, finding in enumerate(document["findings"]):
        with ui.expansion(value=number in new_findings[:1]).classes("w-full") as box:
            _draw_finding(finding, number)
            if figures and finding["effect"] in figures.figures:
                label = f"residual without and with {finding['effect']}"
                page.draw_figure(figures.figures[finding["effect"]], label)
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
        _draw_formula(page, remaining["formula"], made.findings.law or "")
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


def steps_figure(made: StepsView) -> Figure:
    """Plot the training and held-out error of each model."""
    names = [f"{number}  {theme.escaped(step.label)}" for number, step in enumerate(made.steps)]
    return to_dict(rms_bars(names, [step.entry for step in made.steps], made.noise_rms, made.units))


def branches_figure(history: History) -> Figure:
    """Plot the errors of the first model and of the last one of each branch."""
    last = {history.title(end): history.entries[end].made for end in history.ends}
    first = history.entries[0].made
    entries = [first.steps[0].entry, *(made.steps[-1].entry for made in last.values())]
    floors = zip(*(made.noise_rms for made in last.values()), strict=True)
    noise = [min((value for value in joint if value is not None), default=None) for joint in floors]
    names = [first.steps[0].label, *last]
    return to_dict(rms_bars([theme.escaped(name) for name in names], entries, noise, first.units))
