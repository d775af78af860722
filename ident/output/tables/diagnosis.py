"""Tables of a diagnosis."""

from collections.abc import Sequence

from ident.diagnosis.document.document import Document, RejectedEntry
from ident.output.tables import ResultTable

_RANKS = {"absorbed": 0, "not-confirmed": 1, "refuted": 2, "not-tested": 3, "not-observable": 4}
"""What was nearly added comes first."""
_NOTABLE = 1.25
"""Ratio of the error on all rows to that on scored rows from which both are shown."""


def steps(document: Document) -> ResultTable:
    """Return the training and the held-out error of each model, above noise floor and torque."""
    last = document.steps[-1]
    named = zip(document.labels, document.steps, strict=True)
    rows = [(label, *_pairs(step.train_rms, step.held_out_rms)) for label, step in named]
    end = len(rows) - 1
    on_all = (*last.train_rms_all, *last.held_out_rms_all)
    if any(x > _NOTABLE * scored for x, scored in zip(on_all, (*last.train_rms, *last.held_out_rms), strict=False)):
        rows.append(("last model, on all rows", *_pairs(last.train_rms_all, last.held_out_rms_all)))
    rows.append(("noise floor, with quantization", *(f"{value:.3g}" for value in document.noise_rms)))
    rows.append(("measured torque", *(f"{value:.3g}" for value in document.torque_rms)))
    return ResultTable(
        ("model", *document.joints),
        rows,
        title=f"RMS error [{', '.join(dict.fromkeys(document.effort_units))}], training | held out",
        sections=(end,),
        styles={len(rows) - 2: "green", len(rows) - 1: "dim"},
    )


def _pairs(train: Sequence[float], held_out: Sequence[float]) -> list[str]:
    return [f"{first:.3g} | {second:.3g}" for first, second in zip(train, held_out, strict=True)]


def rejected(document: Document, most: int | None = None) -> ResultTable:
    """Return the effects that were not added, the nearest first; all, or a table of at most so many rows."""

    def rank(entry: RejectedEntry) -> tuple[bool, int, float]:
        # What screening alone ruled out would explain hardly more than chance.
        screened = entry.evidence is not None and entry.evidence.decided_by == "screening"
        return screened, _RANKS[entry.status], -entry.evidence.gain if entry.evidence else 0.0

    ranked = sorted(document.rejected, key=rank)
    rows: list[tuple[str, str, str]] = [(entry.effect, entry.status, entry.why) for entry in ranked]
    if most is not None and len(rows) >= most:
        others = f"{len(rows) - most + 1} others", "", "The report and --json list them with the reasons."
        rows[most - 1 :] = [others]
    return ResultTable(("effect", "status", "why"), rows, words=(0, 1, 2), title="Not added")
