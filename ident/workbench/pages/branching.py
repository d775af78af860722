"""Branches: two or more explanations of the same recordings, their errors next to each other."""

from nicegui import ui

from ident.workbench import plots
from ident.workbench.branches import Branches
from ident.workbench.pages.page import Page, set_test_id, draw_figure


def draw(page: Page) -> None:
    """Nothing while there is only one."""
    branches = page.session.branches
    if branches is None or len(branches.all) == 1:
        return
    ui.label("Branches side by side").classes("head q-mt-sm")
    draw_figure(plots.branches(branches.all), "error of each branch, training and held out", page.session.dark)
    with ui.row().classes("items-center gap-2"):
        for place, branch in enumerate(branches.all):
            with ui.row().classes("items-center no-wrap gap-1 chip"):
                label = ui.label(branch.title + (" (present)" if place == branches.index else ""))
                set_test_id(label, f"branch-{branch.name}")
                if place != branches.index:
                    _buttons(page, branches, place)


def _buttons(page: Page, branches: Branches, place: int) -> None:
    session, which = page.session, branches.all[place].name
    for text, act in (("Switch", session.switch), ("Drop", session.drop)):
        button = ui.button(text, on_click=page.handler(act, place)).props("flat dense size=sm no-caps")
        button.props(f'aria-label="{text} {"to" if text == "Switch" else ""} branch {which}"')
        set_test_id(button, f"{text.lower()}-{which}")
