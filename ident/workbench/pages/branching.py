"""Comparison of branches: alternative models of the same recordings with their errors."""

from nicegui import ui

from ident.workbench import plots
from ident.workbench.pages.page import Page, set_test_id


def draw(page: Page) -> None:
    """Draw the branches if there is more than one."""
    selection = page.session.selection
    branches = selection.branches
    if branches is None or len(branches.all) == 1:
        return
    ui.label("Branches").classes("head q-mt-sm")
    page.draw_figure(plots.branches(branches.all), "error of each branch, training and held out")
    with ui.row().classes("items-center gap-2"):
        for index, branch in enumerate(branches.all):
            name, is_current = branch.name, index == branches.index
            with ui.row().classes("items-center no-wrap gap-1 chip"):
                set_test_id(ui.label(branch.title + (" (current)" if is_current else "")), f"branch-{name}")
                if not is_current:
                    style = {"props": "flat dense size=sm"}
                    page.button(
                        "Switch", f"switch-{name}", selection.switch, index, label=f"Switch to branch {name}", **style
                    )
                    page.button("Drop", f"drop-{name}", selection.drop, index, label=f"Drop branch {name}", **style)
