"""Verdict on the current model above the tabs, and the ways on: analyse, save, open the report."""

from nicegui import ui

from ident.workbench.pages import export
from ident.workbench.pages.page import Page, set_test_id


def draw(page: Page) -> None:
    """Draw what is known of the current model."""
    page.draw_on_change(_draw_pending, "job", "step_list", "residuals")
    page.draw_on_change(_draw_verdict, "step_list", "residuals", "saved")


def _draw_pending(page: Page) -> None:
    selection = page.session.selection
    if selection.step_list is None or selection.residuals is not None:
        return
    with ui.row().classes("items-center gap-3 banner"):
        if page.session.jobs.current is not None:
            ui.label("The model is being analysed …")
        else:
            ui.label("The analysis of this model is not complete.")
            page.button("Analyse", "resume-analysis", selection.resume_analysis, props="outline")


def _draw_verdict(page: Page) -> None:
    selection = page.session.selection
    step_list, residuals = selection.step_list, selection.residuals
    if step_list is None or residuals is None or residuals.model.residual_test is None:
        return
    kind = "banner-good" if selection.within_noise else ""
    with ui.row().classes(f"items-center gap-3 banner {kind}"):
        if selection.within_noise:
            ui.icon("check_circle", size="sm")
        set_test_id(ui.label(residuals.model.residual_test.sentence), "floor")
        if selection.within_noise:
            saved = page.session.export.saved_name(residuals.model)
            if saved:
                ui.label(f"Saved as {saved}.")
            else:
                page.button(
                    "Save",
                    "banner-save",
                    _save,
                    page,
                    props="unelevated color=white text-color=positive",
                    icon="save",
                )
            export.draw_report(page, residuals.model, step_list)


def _save(page: Page) -> None:
    """Save the current model under a new name."""
    selection, export = page.session.selection, page.session.export
    if selection.step_list and selection.residuals:
        export.save(selection.residuals.model, export.free_name(selection.step_list))
