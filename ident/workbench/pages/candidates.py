"""Cards of the candidate effects, with the estimated improvement and a preview of each."""

from collections.abc import Sequence
from functools import partial

from nicegui import ui

from ident.workbench.pages.page import Page, heading, quiet, set_test_id
from ident.workbench.worker.views import CandidateCard

_MIN_NOTABLE = 0.05
"""Improvement below which a card is folded away."""
_COLUMNS = "grid-template-columns: repeat(auto-fill, minmax(min(290px, 100%), 1fr))"


def draw(page: Page) -> None:
    """Draw the heading, the preview panel and the cards in descending order of improvement."""
    candidates = _Candidates(page)
    page.draw_on_change(_head, "candidates")
    with ui.element("div").classes("beside candidates"):  # Add is in sight together with what it would explain
        page.draw_on_change(candidates.draw_preview, "candidates", "previews", "residuals").classes("preview")
        page.draw_on_change(candidates.draw_cards, "candidates")
    page.watch(candidates.fold, "residuals", now=False)


def _head(page: Page) -> None:
    if page.session.selection.analysis.candidates is None:
        return
    heading("Candidate effects", "q-mt-sm")
    quiet(
        "Percentage: estimated reduction of the squared error after adding the effect and refitting. Point at a "
        "card, or move to it with Tab, to see its preview."
    )


class _Candidates:
    """Cards, and the preview of one of them in a panel that stays visible; all figures exist already.

    They are drawn apart, because a click on a card that is being redrawn is lost.
    """

    def __init__(self, page: Page) -> None:
        self._page = page
        self._title: ui.label | None = None
        self._plot: ui.plotly | None = None
        self._shown = ""
        self._notable: ui.expansion | None = None

    def draw_preview(self, page: Page) -> None:
        """Draw the preview that was shown before the last change of this model, or that of the best candidate."""
        analysis = page.session.selection.analysis
        candidates, previews = analysis.candidates, analysis.previews
        chosen, self._plot, self._shown = self._shown, None, ""
        if candidates is None or not candidates.cards or page.session.selection.within_noise:
            return
        self._title = set_test_id(ui.label("Drawing the previews …").classes("font-medium"), "preview")
        if previews is None:
            return
        shown = chosen if chosen in previews.figures else candidates.cards[0].name
        label = "residual, and the part that the effect would explain"
        self._plot = page.draw_figure(previews.figures[shown], label)
        self._show(shown)

    def _show(self, effect: str) -> None:
        """Show the preview of another candidate."""
        previews = self._page.session.selection.analysis.previews
        if not (self._plot and self._title and previews) or effect == self._shown:
            return
        self._shown = effect
        self._title.text = f"{effect}: part of the residual that it would explain"
        self._page.update_figure(self._plot, previews.figures[effect])

    def draw_cards(self, page: Page) -> None:
        """Draw the cards that may matter, folded away those that do not, and the names of effects without one."""
        self._notable = None
        candidates = page.session.selection.analysis.candidates
        if candidates is None:
            return
        count = sum(card.improvement >= _MIN_NOTABLE for card in candidates.cards)  # they come in descending order
        notable, minor = candidates.cards[:count], candidates.cards[count:]
        if notable:
            title = f"{_effects(len(notable))} {_MIN_NOTABLE:.0%} or more"
            self._notable = self._draw_grid(notable, title, "notable-cards")
            self.fold(page)
        if minor:
            title = f"{_effects(len(minor))} less than {_MIN_NOTABLE:.0%}"
            self._draw_grid(minor, title, "minor-cards").value = False
        if candidates.not_excited:
            names = ", ".join(candidates.not_excited)
            quiet(f"Not excited by this motion, or only with an inadmissible sign: {names}.")
        for effect, why in candidates.unobservable.items():
            quiet(f"{effect}: {why}")

    def fold(self, page: Page) -> None:
        """Fold all cards away if only noise is left. They are not drawn again, so that no click on them is lost."""
        if self._notable is not None:
            self._notable.value = not page.session.selection.within_noise

    def _draw_grid(self, cards: Sequence[CandidateCard], title: str, test_id: str) -> ui.expansion:
        expansion = set_test_id(ui.expansion(title, value=True).classes("w-full"), test_id)
        with expansion, ui.element("div").classes("w-full grid gap-2").style(_COLUMNS):
            for candidate in cards:
                card = _card(self._page, candidate)
                show = partial(self._show, candidate.name)
                # A card that a scroll moves below a resting pointer gets `mouseenter`, and would take the preview
                # from the focus.
                card.on("mousemove", show, args=[], throttle=0.2).on("focusin", show, args=[])
        return expansion


def _effects(count: int) -> str:
    return "1 effect that explains" if count == 1 else f"{count} effects that explain"


def _card(page: Page, candidate: CandidateCard) -> ui.card:
    effect, name = page.session.library[candidate.name], candidate.name
    joints = f"joint {', '.join(map(str, candidate.joints))}" if candidate.joints else "whole robot"
    card = set_test_id(ui.card().classes("q-pa-sm gap-1").props("flat bordered tabindex=0"), f"card-{name}")
    with card:
        with ui.row().classes("w-full items-center no-wrap"):
            ui.label(name).classes("font-medium ellipsis")
            ui.space()
            set_test_id(ui.label(f"{100 * candidate.improvement:.1f} % of the square"), f"improvement-{name}")
        ui.linear_progress(candidate.improvement, show_value=False, size="6px").props("aria-hidden=true")
        ui.label(effect.sentence).classes("text-sm")
        with ui.row().classes("w-full items-center no-wrap"):
            quiet(joints)
            ui.space()
            page.button("About", f"about-{name}", _show_about, page, name, props="flat dense", label=f"About {name}")
            add_button(page, name)
    return card


def _show_about(page: Page, name: str) -> None:
    """Show equation, symptom, causes and remedy of the effect `name` in a dialog."""
    effect = page.session.library[name]
    with page.dialog(f"About {name}") as dialog, ui.card().classes("max-w-md gap-0"):
        for label, text in (
            ("Equation", effect.equation),
            ("Symptom", effect.symptom),
            ("Usual causes", effect.causes),
            ("Remedy", effect.remedy),
        ):
            quiet(label)
            ui.label(text).classes("q-mb-xs")
        ui.button("Close", on_click=dialog.close).props("outline autofocus")
    dialog.open()


def add_button(page: Page, effect: str, test_id: str = "") -> None:
    """Draw a button that adds `effect` to the model."""
    add = (page.session.selection.extend, "add", effect)
    page.button("Add", test_id or f"add-{effect}", *add, props="dense unelevated", label=f"Add {effect}")
