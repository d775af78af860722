"""Print the scores of all cases in one table, and each case that is not right."""

from collections.abc import Iterator

import numpy as np

from benchmarks.formulas.scoring import ScoredFormula

_REACHED = 1.2
"""Held-out error over that of the right model up to which a case counts as solved."""
_COLUMNS = ("cases", "found", "right", "false", "before", "after", f"<= {_REACHED:g}", "terms", "seconds")
_EXPLANATION = """\
found: cases with a formula; right: of these, with the quantities of the hidden law; false: with others
before, after: median held-out error over that of the right model, without and with the formula
seconds: to find the formula"""


def lines(scored: list[ScoredFormula]) -> Iterator[str]:
    """Yield the table, by what is hidden, and a line for each case without the right formula."""
    yield f"{'hidden':18}" + "".join(f"{name:>8}" for name in _COLUMNS)
    for law in sorted({each.law for each in scored}):
        yield f"{law:18}{_cells([each for each in scored if each.law == law])}"
    yield f"{'all':18}{_cells(scored)}\n{_EXPLANATION}"
    for each in scored:
        if not each.right and each.case.kind != "nothing":
            yield f"  {each.case.name}: {each.before:.2f} to {each.after:.2f}: {each.text or 'no formula'}"


def _cells(scored: list[ScoredFormula]) -> str:
    found = [each for each in scored if each.terms]
    right, reached = sum(each.right for each in found), sum(each.after <= _REACHED for each in scored)
    before, after, seconds = np.median([(each.before, each.after, each.seconds) for each in scored], axis=0)
    counts = f"{len(scored):8}{len(found):8}{right:8}{len(found) - right:8}{before:8.2f}{after:8.2f}{reached:8}"
    return f"{counts}{np.median([each.terms for each in found] or [0]):8.1f}{seconds:8.1f}"
