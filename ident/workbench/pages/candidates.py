"""Cards of the candidate effects, with the estimated improvement and a preview of each."""

from collections.abc import Callable
from functools import partial

from nicegui import ui

from ident.workbench.pages.page import Page, set_test_id
from ident.workbench.views import CandidateCard

_COLUMNS = "grid-template-columns: repeat(auto-fill, minmax(290px, 1fr))"


class PreviewPanel:
    """Preview of one candidate in a panel that stays visible; all figures exist already.

    It is drawn separately from the cards, because a click on a card that is being redrawn is lost.
    """

    def __init__(self) -> None:
        self.show: Callable[[str], None] = lambda effect: None
        """Show the preview of another candidate."""

    def draw(self, page: Page) -> None:
        """Draw the preview of the best candidate."""
        candidates, previews = page.session.selection.candidates, page.session.selection.previews
        self.show = lambda effect: None
        if candidates is None or not candidates.cards:
            return
        title = set_test_id(ui.label("Drawing the previews …").classes("font-medium"), "preview")
        if previews is None:
            return
        best, figures = candidates.cards[0].name, previews.figures
        plot = page.draw_figure(figures[best], "residual, and the part that the effect would explain")

        def show(effect: str) -> None:
            title.text = f"{effect}: part of the residual that it would explain"
            page.update_figure(plot, figures[effect])

        self.show = show
        show(best)


def draw(page: Page) -> None:
    """Draw the heading, the preview panel and the cards in descending order of improvement."""
    panel = PreviewPanel()
    page.draw_on_change(_head, "candidates", "job")
    page.draw_on_change(panel.draw, "candidates", "previews").classes("preview")
    page.draw_on_change(partial(_cards, panel=panel), "candidates")


def _head(page: Page) -> None:
    selection = page.session.selection
    if selection.ladder is None:
        return
    if selection.candidates is not None:
        ui.label("Candidate effects").classes("head q-mt-sm")
        ui.label(
            "Percentage: estimated reduction of the squared error after adding the effect and refitting. Point at a "
            "card, or move to it with Tab, to see its preview."
        ).classes("quiet")
    elif page.session.jobs.current is not None:
        ui.label("Rating every effect of the library …").classes("quiet")
    else:
        ui.label("The analysis was cancelled before it was complete.").classes("quiet")
        page.button("Rate every effect", "resume-analysis", selection.resume_analysis, props="outline")


def _cards(page: Page, panel: PreviewPanel) -> None:
    candidates = page.session.selection.candidates
    if candidates is None:
        return
    with ui.element("div").classes("w-full grid gap-2").style(_COLUMNS):
        for candidate in candidates.cards:
            _card(page, candidate, panel)
    if candidates.not_excited:
        names = ", ".join(candidates.not_excited)
        ui.label(f"Not excited by this motion, or only with an inadmissible sign: {names}.").classes("quiet q-mt-sm")
    for effect, why in candidates.unobservable.items():
        ui.label(f"{effect}: {why}").classes("quiet")


def _card(page: Page, candidate: CandidateCard, panel: PreviewPanel) -> None:
    effect, name = page.session.library[candidate.name], candidate.name
    joints = f"joint {', '.join(map(str, candidate.joints))}" if candidate.joints else "whole robot"
    card = set_test_id(ui.card().classes("q-pa-sm gap-1").props("flat bordered tabindex=0"), f"card-{name}")
    for event in ("mouseenter", "focusin"):
        card.on(event, lambda: panel.show(name), args=[])
    with card:
        with ui.row().classes("w-full items-center no-wrap"):
            ui.label(name).classes("font-medium ellipsis")
            ui.space()
            set_test_id(ui.label(f"{100 * candidate.improvement:.1f} %"), f"improvement-{name}")
        ui.linear_progress(candidate.improvement, show_value=False, size="6px").props("aria-hidden=true")
        ui.label(effect.sentence).classes("text-sm")
        with ui.row().classes("w-full items-center no-wrap"):
            ui.label(joints).classes("quiet")
            ui.space()
            with ui.button("About").props("flat dense size=sm"), ui.menu().classes("q-pa-md max-w-md"):
                for label, text in (
                    ("Equation", effect.equation),
                    ("Symptom", effect.symptom),
                    ("Usual causes", effect.causes),
                    ("Remedy", effect.remedy),
                ):
                    ui.label(label).classes("quiet")
                    ui.label(text).classes("q-mb-xs")
            add_button(page, name)


def add_button(page: Page, effect: str) -> None:
    """Draw a button that adds `effect` to the model."""
    props = f'dense size=sm unelevated aria-label="Add {effect}"'
    page.button("Add", f"add-{effect}", page.session.selection.add, effect, props=props)
