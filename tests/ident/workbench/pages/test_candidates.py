"""Cards that may matter, and cards that are folded away."""

from ident.workbench.pages.candidates import MIN_NOTABLE, split_cards
from ident.workbench.views import CandidateCard


def test_cards_that_explain_little_are_folded_away() -> None:
    cards = tuple(CandidateCard(str(share), (1,), share) for share in (0.6, MIN_NOTABLE, 0.049, 0.0))
    assert split_cards(cards) == (cards[:2], cards[2:])
    assert split_cards(()) == ((), ())
