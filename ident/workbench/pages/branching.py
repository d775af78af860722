"""Comparison of branches: alternative models of the same recordings with their errors."""

from nicegui import ui

from ident.workbench import plots
from ident.workbench.branches import Branches
from ident.workbench.pages.page import Page, draw_figure, set_test_id


def draw(page: Page) -> None:
    """Draw the branches if there is more than one."""
    branches = page.session.branches
    if branches is None or len(branches.all) == 1:
        return
    ui.label("Branches").classes("head q-mt-sm")
    draw_figure(plots.branches(branches.all), "error of each branch, training and held out", page.session.dark)
    with ui.row().classes("items-center gap-2"):
        for index, branch in enumerate(branches.all):
            with ui.row().classes("items-center no-wrap gap-1 chip"):
                label = ui.label(branch.title + (" (current)" if index == branches.index else ""))
                set_test_id(label, f"branch-{branch.name}")
                if index != branches.index:
                    _buttons(page, branches, index)


def _buttons(page: Page, branches: Branches, index: int) -> None:
    session, branch = page.session, branches.all[index].name
    for text, action in (("Switch", session.switch), ("Drop", session.drop)):
        button = ui.button(text, on_click=page.handler(action, index)).props("flat dense size=sm no-caps")
        button.props(f'aria-label="{text} {"to" if text == "Switch" else ""} branch {branch}"')
        set_test_id(button, f"{text.lower()}-{branch}")
