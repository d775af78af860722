"""What could be missing: the effects of the library as cards, with what each would take away, and the look of it."""

from collections.abc import Callable

from nicegui import ui

from ident.workbench import plots
from ident.workbench.pages.page import Page, set_test_id, draw_figure
from ident.workbench.views import CandidateCard

_COLUMNS = "grid-template-columns: repeat(auto-fill, minmax(290px, 1fr))"


class PreviewPanel:
    """What one candidate would take away, in a place that stays in sight; the pictures are all made already.

    It comes after the cards, which are not drawn again for it: a click on a card that is being replaced is lost.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        self._title: ui.label | None = None
        self._plot: ui.plotly | None = None

    def draw(self) -> None:
        """Of the most promising candidate."""
        session = self._page.session
        self._title = self._plot = None
        if session.candidates is None or not session.candidates.cards:
            return
        self._title = ui.label("Its signature is being drawn …").classes("font-medium")
        set_test_id(self._title, "foretaste")
        if session.previews is None:
            return
        first = session.candidates.cards[0].name
        figure = session.previews.figures[first]
        self._plot = draw_figure(figure, "residual, and what the effect would take away", session.dark)
        self.show(first)

    def show(self, effect: str) -> None:
        """Turn to another candidate."""
        known = self._page.session.previews
        if self._title is None or self._plot is None or known is None:
            return
        self._title.text = f"{effect}: what it would take away of the residual"
        self._plot.update_figure(plots.with_theme(known.figures[effect], self._page.session.dark))


def draw(page: Page) -> None:
    """The most promising first."""
    foretaste = PreviewPanel(page)
    page.draw_on_change(lambda: _head(page), "choice")
    page.draw_on_change(foretaste.draw, "choice", "signatures").classes("foretaste")
    page.draw_on_change(lambda: _cards(page, foretaste.show), "choice")


def _head(page: Page) -> None:
    session = page.session
    if session.ladder is None:
        return
    if session.candidates is None:
        _analysis_missing(page)
        return
    ui.label("What could be missing").classes("head q-mt-sm")
    ui.label(
        "Share of the squared error that each would take away at first sight, the model refitted. Point at a card, "
        "or move to it with Tab, to see its signature over the residual."
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
        ui.label(f"This motion does not show, or only with an impossible sign: {names}.").classes("quiet q-mt-sm")
    for effect, why in choice.unobservable.items():
        ui.label(f"{effect}: {why}").classes("quiet")


def _analysis_missing(page: Page) -> None:
    if page.session.job is not None:
        ui.label("Looking at every effect of the library …").classes("quiet")
        return
    ui.label("Not all was looked at, because it was cancelled.").classes("quiet")
    again = ui.button("Look at every effect", on_click=page.handler(page.session.resume_analysis)).props("outline no-caps")
    set_test_id(again, "look-again")


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
            set_test_id(ui.label(f"{100 * candidate.improvement:.1f} %"), f"gain-{candidate.name}")
        ui.linear_progress(candidate.improvement, show_value=False, size="6px").props("aria-hidden=true")
        ui.label(effect.sentence).classes("text-sm")
        with ui.row().classes("w-full items-center no-wrap"):
            ui.label(joints).classes("quiet")
            ui.space()
            with ui.button("About").props("flat dense size=sm no-caps"), ui.menu().classes("q-pa-md max-w-md"):
                for label, text in _about(page, candidate.name):
                    ui.label(label).classes("quiet")
                    ui.label(text).classes("q-mb-xs")
            add = ui.button("Add", on_click=_add_handler(page, candidate.name)).props("dense size=sm no-caps unelevated")
            add.props(f'aria-label="Add {candidate.name}"')
            set_test_id(add, f"add-{candidate.name}")


def _about(page: Page, effect: str) -> list[tuple[str, str]]:
    known = page.session.library[effect]
    return [
        ("Equation", known.equation),
        ("What it looks like", known.looks),
        ("Usual causes", known.causes),
        ("What to do", known.remedy),
    ]


def _add_handler(page: Page, effect: str) -> Callable[[], None]:
    return page.handler(page.session.add, effect)
