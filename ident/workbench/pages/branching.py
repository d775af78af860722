"""Comparison of branches: alternative models of the same recordings with their errors."""

from nicegui import ui

from ident.workbench import plots
from ident.workbench.pages.page import Page, heading, set_test_id


def draw(page: Page) -> None:
    """Draw the branches if there is more than one."""
    selection = page.session.selection
    branches = selection.branches
    if branches is None or len(branches.all) == 1:
        return
    heading("Branches", "q-mt-sm")
    page.draw_figure(plots.branches(branches.all), "error of each branch, training and held out")
    with ui.row().classes("items-center gap-2"):
        for index, branch in enumerate(branches.all):
            name, note = branch.name, " (current)" if index == branches.index else ""
            with ui.row().classes("items-center no-wrap gap-1 chip"):
                set_test_id(ui.label(branch.title + note), f"branch-{name}")
                if not note:
                    props = f'flat dense aria-label="Switch to branch {name}"'
                    page.button("Switch", f"switch-{name}", selection.switch, index, props=props)
                    props = f'flat dense aria-label="Drop branch {name}"'
                    page.button("Drop", f"drop-{name}", selection.drop, index, props=props)
