"""Diagnose recordings blind."""

import time
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.hidden_effects.cases import HiddenCase
from benchmarks.hidden_effects.sources import digest

_PACKAGES = ("ident", "recordings", "trajectories")
"""Packages that a diagnosis depends on."""


def engine() -> str:
    """Digest of the diagnosing code, which identifies its version."""
    return digest(_PACKAGES)


def diagnose(case: HiddenCase, root: Path, engine: str) -> dict[str, Any]:
    """Diagnose a case; return the line to store: the document of `ident diagnose`, or the error."""
    from ident.diagnosis.diagnosis import DiagnosisOptions
    from ident.diagnosis.diagnosis import diagnose as run
    from ident.diagnosis.document import verdict

    folder, start = root / case.name, time.monotonic()
    line: dict[str, Any] = {"case": case.name, "engine": engine}
    try:
        diagnosis = run([folder / "train.mcap"], [folder / "validate.mcap"], _library(), DiagnosisOptions())
        line["document"] = _shortened(verdict.to_document(diagnosis).as_json())
    except Exception as error:  # any error is a failed case; the other cases continue
        line["error"] = f"{type(error).__name__}: {error}"
    return line | {"seconds": round(time.monotonic() - start, 2)}


@cache
def _library() -> Any:
    from ident.dynamics.effects.library import library

    return library()


def _shortened(document: dict[str, Any]) -> dict[str, Any]:
    """Document without texts of the library and without the parameters of intermediate models."""
    for step in document["steps"][:-1]:
        step["parameters"] = {}
    for finding in document["findings"]:
        for text in ("sentence", "symptom", "causes", "remedy"):
            finding.pop(text, None)
    return document


def summary(line: dict[str, Any]) -> str:
    """Short text of a stored line."""
    if "error" in line:
        return str(line["error"])
    document = line["document"]
    names = [finding["effect"] for finding in document["findings"]]
    return f"{document['verdict']} {', '.join(names)} ({line['seconds']} s)"
