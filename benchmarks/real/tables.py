"""Print what was claimed about real machines."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

from benchmarks.real.diagnosing import DiagnosedSet


def lines(outcomes: Sequence[DiagnosedSet]) -> Iterator[str]:
    """Yield the table of every data set, and the sum of all claims."""
    total: Counter[str] = Counter()
    for outcome in outcomes:
        manifest, document = outcome.manifest, outcome.document
        yield f"{manifest.name}: {manifest.source}"
        if document is None:
            yield f"  not read: {outcome.problem}"
            yield f"  get it: {manifest.get}"
            continue
        yield f"  verdict {document['verdict']}; held-out error {_errors(document)}"
        if (plain := outcome.plain) is not None:
            yield f"  plain regression: held-out error {', '.join(f'{error:.3g}' for error in plain)}"
        if manifest.published:
            yield f"  published: {manifest.published}"
        for text, judgement in outcome.claims:
            total[judgement] += 1
            yield f"  {judgement:8} {text}"
    yield "claims: " + ", ".join(f"{count} {judgement}" for judgement, count in total.most_common())


def _errors(document: dict[str, Any]) -> str:
    first, last = (document["steps"][index]["held_out_rms"] for index in (0, -1))
    pairs = zip(first, last, document["effort_units"], strict=True)
    return ", ".join(f"{before:.3g} → {after:.3g} {unit}" for before, after, unit in pairs)
