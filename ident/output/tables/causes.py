"""The torque of a path by its causes: table and document."""

from collections.abc import Mapping
from math import isfinite
from typing import Any

from ident.export.torque_table import TorqueSummary
from ident.identification.model import Model
from ident.output.tables import ResultTable, per_joint
from recordings.recording import Floats

Widths = Mapping[str, Floats] | None
"""(dof,) half of each cause's 95 % interval, relative to its RMS; None: not known."""


def table(summary: TorqueSummary, widths: Widths = None) -> ResultTable:
    """Return the RMS of each cause, with half its interval and its share of the torque's."""
    rows = []
    for cause, rms in {**summary.rms, "torque": summary.torque_rms}.items():
        intervals, cells = _intervals(rms, cause, widths), []
        for joint, (x, interval) in enumerate(zip(rms, intervals, strict=True)):
            half = f" ±{interval[1] - x:.3f}" if interval else ""
            cells.append(f"{x:.3f}{half}" + (f" {summary.share[cause][joint]:.0%}" if cause in summary.share else ""))
        rows.append((cause, *cells))
    head = per_joint("RMS", len(summary.torque_rms))
    return ResultTable(head, rows, words=range(len(head)), styles={len(rows) - 1: "bold"})


def document(model: Model, summary: TorqueSummary, widths: Widths) -> dict[str, Any]:
    """Return the document of `ident torque --json`."""
    share = summary.share
    terms = {
        name: {"rms": rms.tolist(), "rms_ci95": _intervals(rms, name, widths), "share": share[name].tolist()}
        for name, rms in summary.rms.items()
    }
    return {
        "schema": 1,
        "relative": model.file.relative,
        "stepped": list(model.stepped),
        "torque_rms": summary.torque_rms.tolist(),
        "torque_rms_ci95": _intervals(summary.torque_rms, "torque", widths),
        "terms": terms,
    }


def _intervals(rms: Floats, cause: str, widths: Widths) -> list[list[float] | None]:
    """95 % interval of each joint's RMS; None where it is not known."""
    if widths is None:
        return [None] * len(rms)
    pairs = [(float(x), float(x * width)) for x, width in zip(rms, widths[cause], strict=True)]
    return [[max(x - half, 0.0), x + half] if isfinite(half) else None for x, half in pairs]
