"""Print the scores of the parts side by side, with the required values."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from benchmarks.hidden_effects.cases import Part
from benchmarks.hidden_effects.figures import Figure, figures
from benchmarks.hidden_effects.scoring import REACHED, ScoredCase

_WORST = 0.9
"""Quantile that is printed with the median."""
_NAME, _REQUIRED, _CELL = 50, 10, 32
"""Widths of the columns."""


def lines(parts: Mapping[Part, Sequence[ScoredCase]]) -> Iterator[str]:
    """Yield the lines of all tables: the scores side by side, then the details of each part."""
    yield _row("", "required", parts)
    for row in zip(*(figures(judgements) for judgements in parts.values()), strict=True):
        if any(figure.hits for figure in row):
            yield _row(row[0].criterion, row[0].requirement, [figure.cell for figure in row])
    yield _row("time for a diagnosis", "", [_seconds(judgements) for judgements in parts.values()])
    yield f"in parentheses: 95 % interval (Wilson); {Figure.MISSED} required share missed"
    for part, judgements in parts.items():
        yield f"\n{part}: {len(judgements)} cases"
        yield from _confusion(judgements)
        yield from _parameters(judgements)
        yield from _failures(judgements)


def _row(name: str, required: str, cells: Iterable[str]) -> str:
    return f"{name:{_NAME}}{required:{_REQUIRED}}{''.join(f'{cell:{_CELL}}' for cell in cells)}".rstrip()


def _seconds(judgements: Sequence[ScoredCase]) -> str:
    seconds = [j.seconds for j in judgements]
    return f"{np.median(seconds):.1f} s, at most {max(seconds):.1f} s"


def _confusion(judgements: Sequence[ScoredCase]) -> Iterator[str]:
    yield "\nhidden effect: first finding and count (in brackets: its group contains the right effect)"
    rows: dict[str, Counter[str]] = {}
    for j in judgements:
        if j.case.kind != "pair":
            row = rows.setdefault(j.case.effects[0] if j.case.effects else "nothing", Counter())
            grouped = j.case.kind in ("single", "added") and j.right and j.first != j.case.effects[0]
            row[f"({j.first})" if grouped else j.first] += 1
    for effect in sorted(rows):
        yield f"  {effect:28}" + ", ".join(f"{diagnosed} {count}" for diagnosed, count in rows[effect].most_common())


def _parameters(judgements: Sequence[ScoredCase]) -> Iterator[str]:
    yield "\nrelative error of the strength: median (90 % quantile)"
    errors: dict[str, list[float]] = {}
    for j in judgements:
        for effect, error in j.errors.items():
            errors.setdefault(effect, []).append(error)
    for effect in sorted(errors):
        finite = [error for error in errors[effect] if np.isfinite(error)]
        if finite:
            median, worst = np.median(finite), np.quantile(finite, _WORST)
            yield f"  {effect:28}{100 * median:7.1f} % ({100 * worst:.1f} %) of {len(finite)}"


def _failures(judgements: Sequence[ScoredCase]) -> Iterator[str]:
    right = [j for j in judgements if j.right]
    kinds = {
        "that were not right": [j for j in judgements if not j.right],
        "on other joints": [j for j in right if not j.right_joints],
        f"with a held-out error above {REACHED:g} noise floors": [
            j for j in right if j.over_floor > REACHED and j.case.kind != "outside"
        ],
    }
    for kind, failed in kinds.items():
        yield f"\n{len(failed)} cases {kind}"
        for j in sorted(failed, key=lambda j: j.case.name):
            yield from _details(j)


def _details(j: ScoredCase) -> Iterator[str]:
    diagnosed = ", ".join("|".join(f.group) + f" {list(f.joints)}" for f in j.findings)
    variables = f" on {', '.join(j.variables) or 'nothing'}" if j.verdict == "unknown-structure" else ""
    truth = "; ".join(f"{effect['name']} {effect['joints']} {100 * effect['size']:.1f} %" for effect in j.truth)
    steps = f" of {j.case.signal_bits} bits" if j.case.signal_bits else ""
    motion = "repeated" if j.case.repeats else "not repeated"
    yield f"  {j.case.name}: {motion}, {j.case.rate:g} Hz, {j.case.signal}{steps}\n      hidden: {truth or 'nothing'}"
    yield f"      found: {j.problem or j.verdict + variables}: {diagnosed}"
    yield f"      held-out error {j.over_floor:.2f} noise floors"
