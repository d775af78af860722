"""Print the scores of all cases in one table, and each case that is not right."""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.formulas.scoring import ScoredFormula

REACHED = 1.2
"""Held-out error over that of the right model up to which a formula counts as complete."""
_HEADER = f"{'hidden':18}{'cases':>6}{'found':>7}{'right':>7}{'false':>7}{'before':>8}{'after':>7}{'<= 1.2':>8}"
_TERMS = f"{'terms':>7}{'seconds':>9}"


def lines(scored: Sequence[ScoredFormula]) -> Iterator[str]:
    """Yield the table, by what is hidden, and a line for each case without the right formula."""
    rivals = sorted({name for each in scored for name in each.rivals})
    yield _HEADER + _TERMS + "".join(f"{name:>26}" for name in rivals)
    for law in sorted({each.law for each in scored}):
        yield _row(law, [each for each in scored if each.law == law], rivals)
    yield _row("all", scored, rivals)
    yield "found: cases with a formula; right: of these, with the quantities of the hidden law; false: with others"
    yield f"before, after: median held-out error over that of the right model; <= {REACHED:g}: cases"
    yield "a rival: median of the same; cases in which the formula's error is smaller; median time"
    for each in scored:
        if not each.right and each.case.kind != "nothing":
            yield f"  {each.case.name}: {each.before:.2f} to {each.after:.2f}: {each.text or 'no formula'}"


def _row(name: str, scored: Sequence[ScoredFormula], rivals: Sequence[str]) -> str:
    found = [each for each in scored if each.terms]
    right = sum(each.right for each in found)
    counts = f"{len(scored):6}{len(found):7}{right:7}{len(found) - right:7}"
    errors = f"{np.median([each.before for each in scored]):8.2f}{np.median([each.after for each in scored]):7.2f}"
    reached = f"{sum(each.after <= REACHED for each in scored):8}"
    terms = f"{np.median([each.terms for each in found]) if found else 0:7.1f}"
    seconds = f"{np.nanmedian([each.seconds for each in scored]):9.1f}"
    return f"{name:18}{counts}{errors}{reached}{terms}{seconds}{''.join(_rival(each, scored) for each in rivals)}"


def _rival(name: str, scored: Sequence[ScoredFormula]) -> str:
    competed = [each for each in scored if name in each.rivals]
    if not competed:
        return f"{'':26}"
    error, seconds = np.median([each.rivals[name] for each in competed], axis=0)
    better = sum(each.after < each.rivals[name][0] for each in competed)
    return f"{error:11.2f}{better:5}/{len(competed):<3}{seconds:6.1f}"
