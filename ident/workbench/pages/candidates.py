"""What could be missing: the effects of the library as cards, with what each would take away, and the look of it."""

from collections.abc import Callable

from nicegui import ui

from ident.workbench import plots
from ident.workbench.pages.page import Page, name, picture
from ident.workbench.views import Candidate

_COLUMNS = "grid-template-columns: repeat(auto-fill, minmax(290px, 1fr))"


class Foretaste:
    """What one candidate would take away, in a place that stays in sight; the pictures are all made already.

    It comes after the cards, which are not drawn again for it: a click on a card that is being replaced is lost.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        self._title: ui.label | None = None
        self._drawn: ui.plotly | None = None

    def draw(self) -> None:
        """Of the most promising candidate."""
        session = self._page.session
        self._title = self._drawn = None
        if session.choice is None or not session.choice.candidates:
            return
        self._title = ui.label("Its signature is being drawn …").classes("font-medium")
        name(self._title, "foretaste")
        if session.signatures is None:
            return
        first = session.choice.candidates[0].name
        figure = session.signatures.figures[first]
        self._drawn = picture(figure, "residual, and what the effect would take away", session.dark)
        self.look(first)

    def look(self, effect: str) -> None:
        """Turn to another candidate."""
        known = self._page.session.signatures
        if self._title is None or self._drawn is None or known is None:
            return
        self._title.text = f"{effect}: what it would take away of the residual"
        self._drawn.update_figure(plots.shown(known.figures[effect], self._page.session.dark))


def draw(page: Page) -> None:
    """The most promising first."""
    foretaste = Foretaste(page)
    page.follow(lambda: _head(page), "choice")
    page.follow(foretaste.draw, "choice", "signatures").classes("foretaste")
    page.follow(lambda: _cards(page, foretaste.look), "choice")


def _head(page: Page) -> None:
    session = page.session
    if session.ladder is None:
        return
    if session.choice is None:
        _none_yet(page)
        return
    ui.label("What could be missing").classes("head q-mt-sm")
    ui.label(
        "Share of the squared error that each would take away at first sight, the model refitted. Point at a card, "
        "or move to it with Tab, to see its signature over the residual."
    ).classes("quiet")


def _cards(page: Page, look: Callable[[str], None]) -> None:
    choice = page.session.choice
    if choice is None:
        return
    with ui.element("div").classes("w-full grid gap-2").style(_COLUMNS):
        for candidate in choice.candidates:
            _card(page, candidate, look)
    if choice.unseen:
        names = ", ".join(choice.unseen)
        ui.label(f"This motion does not show, or only with an impossible sign: {names}.").classes("quiet q-mt-sm")
    for effect, why in choice.unobservable.items():
        ui.label(f"{effect}: {why}").classes("quiet")


def _none_yet(page: Page) -> None:
    if page.session.job is not None:
        ui.label("Looking at every effect of the library …").classes("quiet")
        return
    ui.label("Not all was looked at, because it was cancelled.").classes("quiet")
    again = ui.button("Look at every effect", on_click=page.does(page.session.look_again)).props("outline no-caps")
    name(again, "look-again")


def _card(page: Page, candidate: Candidate, look: Callable[[str], None]) -> None:
    effect = page.session.library[candidate.name]
    joints = f"joint {', '.join(map(str, candidate.joints))}" if candidate.joints else "whole robot"
    card = ui.card().classes("q-pa-sm gap-1").props("flat bordered tabindex=0")
    name(card, f"card-{candidate.name}")
    for event in ("mouseenter", "focusin"):
        card.on(event, lambda: look(candidate.name), args=[])
    with card:
        with ui.row().classes("w-full items-center no-wrap"):
            ui.label(candidate.name).classes("font-medium ellipsis")
            ui.space()
            name(ui.label(f"{100 * candidate.gain:.1f} %"), f"gain-{candidate.name}")
        ui.linear_progress(candidate.gain, show_value=False, size="6px").props("aria-hidden=true")
        ui.label(effect.sentence).classes("text-sm")
        with ui.row().classes("w-full items-center no-wrap"):
            ui.label(joints).classes("quiet")
            ui.space()
            with ui.button("About").props("flat dense size=sm no-caps"), ui.menu().classes("q-pa-md max-w-md"):
                for label, text in _about(page, candidate.name):
                    ui.label(label).classes("quiet")
                    ui.label(text).classes("q-mb-xs")
            add = ui.button("Add", on_click=_adds(page, candidate.name)).props("dense size=sm no-caps unelevated")
            add.props(f'aria-label="Add {candidate.name}"')
            name(add, f"add-{candidate.name}")


def _about(page: Page, effect: str) -> list[tuple[str, str]]:
    known = page.session.library[effect]
    return [
        ("Equation", known.equation),
        ("What it looks like", known.looks),
        ("Usual causes", known.causes),
        ("What to do", known.remedy),
    ]


def _adds(page: Page, effect: str) -> Callable[[], None]:
    return page.does(page.session.add, effect)
