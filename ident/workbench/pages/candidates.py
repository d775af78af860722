"""Cards of the candidate effects, with the estimated improvement and a preview of each."""

from collections.abc import Callable

from nicegui import ui

from ident.workbench.pages.page import Page, set_test_id
from ident.workbench.views import CandidateCard

_COLUMNS = "grid-template-columns: repeat(auto-fill, minmax(290px, 1fr))"


class PreviewPanel:
    """Preview of one candidate in a panel that stays visible; all figures exist already.

    It is drawn separately from the cards, because a click on a card that is being redrawn is lost.
    """

    def __init__(self, page: Page) -> None:
        self._page, self._selection = page, page.session.selection
        self._title: ui.label | None = None
        self._plot: ui.plotly | None = None

    def draw(self) -> None:
        """Draw the preview of the best candidate."""
        candidates, previews = self._selection.candidates, self._selection.previews
        self._title = self._plot = None
        if candidates is None or not candidates.cards:
            return
        self._title = set_test_id(ui.label("Drawing the previews …").classes("font-medium"), "preview")
        if previews is None:
            return
        best = candidates.cards[0].name
        label = "residual, and the part that the effect would explain"
        self._plot = self._page.draw_figure(previews.figures[best], label)
        self.show(best)

    def show(self, effect: str) -> None:
        """Show the preview of another candidate."""
        previews = self._selection.previews
        if self._title is None or self._plot is None or previews is None:
            return
        self._title.text = f"{effect}: part of the residual that it would explain"
        self._page.update_figure(self._plot, previews.figures[effect])


def draw(page: Page) -> None:
    """Draw the heading, the preview panel and the cards in descending order of improvement."""
    panel = PreviewPanel(page)
    page.draw_on_change(lambda: _head(page), "candidates", "job")
    page.draw_on_change(panel.draw, "candidates", "previews").classes("preview")
    page.draw_on_change(lambda: _cards(page, panel.show), "candidates")


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


def _cards(page: Page, show_preview: Callable[[str], None]) -> None:
    candidates = page.session.selection.candidates
    if candidates is None:
        return
    with ui.element("div").classes("w-full grid gap-2").style(_COLUMNS):
        for candidate in candidates.cards:
            _card(page, candidate, show_preview)
    if candidates.not_excited:
        names = ", ".join(candidates.not_excited)
        ui.label(f"Not excited by this motion, or only with an inadmissible sign: {names}.").classes("quiet q-mt-sm")
    for effect, why in candidates.unobservable.items():
        ui.label(f"{effect}: {why}").classes("quiet")


def _card(page: Page, candidate: CandidateCard, show_preview: Callable[[str], None]) -> None:
    effect, name = page.session.library[candidate.name], candidate.name
    joints = f"joint {', '.join(map(str, candidate.joints))}" if candidate.joints else "whole robot"
    card = set_test_id(ui.card().classes("q-pa-sm gap-1").props("flat bordered tabindex=0"), f"card-{name}")
    for event in ("mouseenter", "focusin"):
        card.on(event, lambda: show_preview(name), args=[])
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
    props = "dense size=sm unelevated"
    page.button("Add", f"add-{effect}", page.session.selection.add, effect, props=props, label=f"Add {effect}")
