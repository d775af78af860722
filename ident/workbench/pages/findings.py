"""Findings of the full diagnosis with their evidence."""

from typing import Any

from nicegui import ui

from ident.workbench.pages.page import Page, heading, set_test_id


def draw(page: Page) -> None:
    """Draw the diagnosis if there is one."""
    diagnosis, library = page.session.selection.diagnosis, page.session.library
    if diagnosis is None:
        return
    document = diagnosis.document
    heading("Full diagnosis", "q-mt-sm")
    set_test_id(ui.label(document["sentence"]), "verdict")
    new_findings = [n for n, finding in enumerate(document["findings"]) if not library[finding["effect"]].mandatory]
    for number, finding in enumerate(document["findings"]):
        with ui.expansion(value=number in new_findings[:1]).classes("w-full") as box:
            _finding(finding, number)
            figure = diagnosis.figures.get(finding["effect"])
            if figure:
                page.draw_figure(figure, f"residual without and with {finding['effect']}")
        with box.add_slot("header"):
            _header(finding, number)
    for likely in document["likely"]:
        ui.label(f"Likely: {likely['effect']} (joint {', '.join(map(str, likely['joints']))}). {likely['why']}")
    remaining, motion = document["remaining"], document["next_motion"]
    if remaining["why"]:
        share = 100 * remaining["structured_share"]
        structured = f"{share:.0f} % of it is structured; " if document["verdict"] == "unknown-structure" else ""
        ui.label(f"Unexplained residual: {structured}{remaining['why']}").classes("quiet")
    if motion:
        ui.label(f"Record next: {motion['why']} {motion['command']}").classes("quiet")
    with ui.expansion("Rejected effects").classes("w-full"):
        for candidate in document["rejected"]:
            ui.label(f"{candidate['effect']}: {candidate['why']}").classes("text-sm")


def _header(finding: dict[str, Any], number: int) -> None:
    with ui.row().classes("w-full items-center gap-3"):
        set_test_id(ui.label(finding["effect"]).classes("font-medium"), f"finding-{number}")
        ui.label(f"joint {', '.join(map(str, finding['joints']))}").classes("quiet")
        if finding["share"] is not None:
            ui.label(f"{100 * finding['share']:.0f} % of the first model's held-out error above the noise floor")


def _finding(finding: dict[str, Any], number: int) -> None:
    for label, text in (
        ("Effect", finding["sentence"]),
        ("Evidence", finding["why"]),
        ("Symptom", finding["symptom"]),
        ("Usual causes", finding["causes"]),
        ("Remedy", finding["remedy"]),
        ("Confusable with", ", ".join(finding["confusable_with"]) or "no other effect of the library on these data"),
    ):
        with ui.row().classes("no-wrap gap-3 q-py-xs"):
            ui.label(label).classes("quiet w-32 shrink-0")
            set_test_id(ui.label(text), f"finding-{number}-{label.lower().replace(' ', '-')}")
