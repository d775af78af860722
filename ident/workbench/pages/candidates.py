"""Cards of the candidate effects, with the estimated improvement and a preview of each."""

from collections.abc import Callable, Sequence

from nicegui import ui

from ident.workbench.pages.page import Page, heading, quiet, set_test_id
from ident.workbench.worker.views import CandidateCard

MIN_NOTABLE = 0.05
"""Improvement below which a card is folded away."""
_COLUMNS = "grid-template-columns: repeat(auto-fill, minmax(min(290px, 100%), 1fr))"


class PreviewPanel:
    """Preview of one candidate in a panel that stays visible; all figures exist already.

    It is drawn separately from the cards, because a click on a card that is being redrawn is lost.
    """

    def __init__(self) -> None:
        self.show: Callable[[str], None] = lambda effect: None
        """Show the preview of another candidate."""

    def draw(self, page: Page) -> None:
        """Draw the preview of the best candidate."""
        analysis = page.session.selection.analysis
        candidates, previews = analysis.candidates, analysis.previews
        self.show = lambda effect: None
        if candidates is None or not candidates.cards or page.session.selection.within_noise:
            return
        title = set_test_id(ui.label("Drawing the previews …").classes("font-medium"), "preview")
        if previews is None:
            return
        best, figures = candidates.cards[0].name, previews.figures
        plot = page.draw_figure(figures[best], "residual, and the part that the effect would explain")
        shown: str | None = None

        def show(effect: str) -> None:
            nonlocal shown
            if effect == shown:
                return
            shown = effect
            title.text = f"{effect}: part of the residual that it would explain"
            page.update_figure(plot, figures[effect])

        self.show = show
        show(best)


def draw(page: Page) -> None:
    """Draw the heading, the preview panel and the cards in descending order of improvement."""
    panel = PreviewPanel()
    cards = Cards(panel)
    page.draw_on_change(_head, "candidates")
    page.draw_on_change(panel.draw, "candidates", "previews", "residuals").classes("preview")
    page.draw_on_change(cards.draw, "candidates")
    page.watch(cards.fold, "residuals", now=False)


def _head(page: Page) -> None:
    if page.session.selection.analysis.candidates is None:
        return
    heading("Candidate effects", "q-mt-sm")
    quiet(
        "Percentage: estimated reduction of the squared error after adding the effect and refitting. Point at a "
        "card, or move to it with Tab, to see its preview."
    )


class Cards:
    """The cards: those that may matter, and folded away those that do not."""

    def __init__(self, panel: PreviewPanel) -> None:
        self._panel = panel
        self._notable: ui.expansion | None = None

    def draw(self, page: Page) -> None:
        """Draw all cards, and the names of the effects that have none."""
        self._notable = None
        candidates = page.session.selection.analysis.candidates
        if candidates is None:
            return
        count = sum(card.improvement >= MIN_NOTABLE for card in candidates.cards)  # they come in descending order
        notable, minor = candidates.cards[:count], candidates.cards[count:]
        if notable:
            title = f"{len(notable)} effects that explain {MIN_NOTABLE:.0%} or more"
            self._notable = self._draw_grid(page, notable, title, "notable-cards")
            self.fold(page)
        if minor:
            title = f"{len(minor)} effects that explain less than {MIN_NOTABLE:.0%}"
            self._draw_grid(page, minor, title, "minor-cards").value = False
        if candidates.not_excited:
            names = ", ".join(candidates.not_excited)
            quiet(f"Not excited by this motion, or only with an inadmissible sign: {names}.")
        for effect, why in candidates.unobservable.items():
            quiet(f"{effect}: {why}")

    def fold(self, page: Page) -> None:
        """Fold all cards away if only noise is left. They are not drawn again, so that no click on them is lost."""
        if self._notable is not None:
            self._notable.value = not page.session.selection.within_noise

    def _draw_grid(self, page: Page, cards: Sequence[CandidateCard], title: str, test_id: str) -> ui.expansion:
        expansion = set_test_id(ui.expansion(title, value=True).classes("w-full"), test_id)
        with expansion, ui.element("div").classes("w-full grid gap-2").style(_COLUMNS):
            for candidate in cards:
                _card(page, candidate, self._panel)
        return expansion


def _card(page: Page, candidate: CandidateCard, panel: PreviewPanel) -> None:
    effect, name = page.session.library[candidate.name], candidate.name
    joints = f"joint {', '.join(map(str, candidate.joints))}" if candidate.joints else "whole robot"
    card = set_test_id(ui.card().classes("q-pa-sm gap-1").props("flat bordered tabindex=0"), f"card-{name}")
    # A card that a scroll moves below a resting pointer gets `mouseenter`, and would take the preview from the focus.
    card.on("mousemove", lambda: panel.show(name), args=[], throttle=0.2)
    card.on("focusin", lambda: panel.show(name), args=[])
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
            props = f'flat dense aria-label="About {name}"'
            page.button("About", f"about-{name}", _show_about, page, name, props=props)
            add_button(page, name)


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


def add_button(page: Page, effect: str) -> None:
    """Draw a button that adds `effect` to the model."""
    props = f'dense unelevated aria-label="Add {effect}"'
    page.button("Add", f"add-{effect}", page.session.selection.extend, "add", effect, props=props)
