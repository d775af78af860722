"""Cards of the candidate effects, with the estimated improvement and a preview of each."""

from collections.abc import Callable

from nicegui import ui

from ident.workbench import plots
from ident.workbench.pages.page import Page, draw_figure, set_test_id
from ident.workbench.views import CandidateCard

_COLUMNS = "grid-template-columns: repeat(auto-fill, minmax(290px, 1fr))"


class PreviewPanel:
    """Preview of one candidate in a panel that stays visible; all figures exist already.

    It is drawn separately from the cards, because a click on a card that is being redrawn is lost.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        self._title: ui.label | None = None
        self._plot: ui.plotly | None = None

    def draw(self) -> None:
        """Draw the preview of the best candidate."""
        session = self._page.session
        self._title = self._plot = None
        if session.candidates is None or not session.candidates.cards:
            return
        self._title = ui.label("Drawing the previews …").classes("font-medium")
        set_test_id(self._title, "preview")
        if session.previews is None:
            return
        first = session.candidates.cards[0].name
        figure = session.previews.figures[first]
        self._plot = draw_figure(figure, "residual, and the part that the effect would explain", session.dark)
        self.show(first)

    def show(self, effect: str) -> None:
        """Show the preview of another candidate."""
        previews = self._page.session.previews
        if self._title is None or self._plot is None or previews is None:
            return
        self._title.text = f"{effect}: part of the residual that it would explain"
        self._plot.update_figure(plots.with_theme(previews.figures[effect], self._page.session.dark))


def draw(page: Page) -> None:
    """Draw the heading, the preview panel and the cards in descending order of improvement."""
    panel = PreviewPanel(page)
    page.draw_on_change(lambda: _head(page), "candidates")
    page.draw_on_change(panel.draw, "candidates", "previews").classes("preview")
    page.draw_on_change(lambda: _cards(page, panel.show), "candidates")


def _head(page: Page) -> None:
    session = page.session
    if session.ladder is None:
        return
    if session.candidates is None:
        _analysis_missing(page)
        return
    ui.label("Candidate effects").classes("head q-mt-sm")
    ui.label(
        "Percentage: estimated reduction of the squared error after adding the effect and refitting. Point at a "
        "card, or move to it with Tab, to see its preview."
    ).classes("quiet")


def _cards(page: Page, show_preview: Callable[[str], None]) -> None:
    choice = page.session.candidates
    if choice is None:
        return
    with ui.element("div").classes("w-full grid gap-2").style(_COLUMNS):
        for candidate in choice.cards:
            _card(page, candidate, show_preview)
    if choice.not_excited:
        names = ", ".join(choice.not_excited)
        ui.label(f"Not excited by this motion, or only with an inadmissible sign: {names}.").classes("quiet q-mt-sm")
    for effect, why in choice.unobservable.items():
        ui.label(f"{effect}: {why}").classes("quiet")


def _analysis_missing(page: Page) -> None:
    if page.session.job is not None:
        ui.label("Rating every effect of the library …").classes("quiet")
        return
    ui.label("The analysis was cancelled before it was complete.").classes("quiet")
    button = ui.button("Rate every effect", on_click=page.handler(page.session.resume_analysis)).props(
        "outline no-caps"
    )
    set_test_id(button, "resume-analysis")


def _card(page: Page, candidate: CandidateCard, show_preview: Callable[[str], None]) -> None:
    effect = page.session.library[candidate.name]
    joints = f"joint {', '.join(map(str, candidate.joints))}" if candidate.joints else "whole robot"
    card = ui.card().classes("q-pa-sm gap-1").props("flat bordered tabindex=0")
    set_test_id(card, f"card-{candidate.name}")
    for event in ("mouseenter", "focusin"):
        card.on(event, lambda: show_preview(candidate.name), args=[])
    with card:
        with ui.row().classes("w-full items-center no-wrap"):
            ui.label(candidate.name).classes("font-medium ellipsis")
            ui.space()
            set_test_id(ui.label(f"{100 * candidate.improvement:.1f} %"), f"improvement-{candidate.name}")
        ui.linear_progress(candidate.improvement, show_value=False, size="6px").props("aria-hidden=true")
        ui.label(effect.sentence).classes("text-sm")
        with ui.row().classes("w-full items-center no-wrap"):
            ui.label(joints).classes("quiet")
            ui.space()
            with ui.button("About").props("flat dense size=sm no-caps"), ui.menu().classes("q-pa-md max-w-md"):
                for label, text in _about(page, candidate.name):
                    ui.label(label).classes("quiet")
                    ui.label(text).classes("q-mb-xs")
            add = ui.button("Add", on_click=_add_handler(page, candidate.name)).props(
                "dense size=sm no-caps unelevated"
            )
            add.props(f'aria-label="Add {candidate.name}"')
            set_test_id(add, f"add-{candidate.name}")


def _about(page: Page, effect: str) -> list[tuple[str, str]]:
    definition = page.session.library[effect]
    return [
        ("Equation", definition.equation),
        ("Symptom", definition.symptom),
        ("Usual causes", definition.causes),
        ("Remedy", definition.remedy),
    ]


def _add_handler(page: Page, effect: str) -> Callable[[], None]:
    return page.handler(page.session.add, effect)
