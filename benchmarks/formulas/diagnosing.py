"""Diagnose a case, propose a formula, and measure what the right model reaches on the same rows."""

import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.hidden_effects.cases import HiddenCase
from benchmarks.hidden_effects.foreign import setting_of
from drivers.simulated.seal import sealed_path, unseal
from ident.diagnosis.diagnosis import Diagnosis, DiagnosisOptions, diagnose
from ident.diagnosis.split.split_data import rms
from ident.diagnosis.unknown.proposal import propose
from ident.dynamics.effects.library import library
from tests.foreign.pairs import TRAIN, VALIDATE, make


def run(case: HiddenCase, root: Path, engine: str) -> dict[str, Any]:
    """Diagnose a recorded case; return the line to store: formula, errors per joint [N m] and times [s]."""
    start = time.monotonic()
    line: dict[str, Any] = {"case": case.name, "engine": engine}
    try:
        diagnosis = _diagnose(root / case.name, DiagnosisOptions())
        diagnosed = time.monotonic()
        line |= _proposed(diagnosis) | {"propose_seconds": time.monotonic() - diagnosed}
        line |= {"diagnose_seconds": diagnosed - start, "floor": _floor(case, root, diagnosis)}
    except Exception as error:  # any error is a failed case; the other cases continue
        line["error"] = f"{type(error).__name__}: {error}"
    return line


def _diagnose(folder: Path, options: DiagnosisOptions) -> Diagnosis:
    return diagnose([folder / TRAIN], [folder / VALIDATE], library(), options)


def _proposed(diagnosis: Diagnosis) -> dict[str, Any]:
    """The formula, and held-out errors per joint [N m] without and with it."""
    model, proposal = diagnosis.model, propose(diagnosis.model, diagnosis.unexplained)
    models = {"before": model, "after": proposal.after if proposal else model}
    errors = {key: rms(each.residuals, model.split.test).tolist() for key, each in models.items()}
    return errors | {
        "effects": [term.name for term in model.terms],
        "unexplained": [joint + 1 for joint in diagnosis.unexplained.joints],
        "formula": {
            "columns": proposal.columns if proposal else (),
            "joints": [joint + 1 for joint in proposal.term.joints] if proposal else [],
            "terms": len(proposal.laws) if proposal else 0,
            "alternatives": proposal.alternatives if proposal else (),
        },
    }


def _floor(case: HiddenCase, root: Path, diagnosis: Diagnosis) -> list[float]:
    """(dof,) held-out error of the right model, where the same robot does the same motions with nothing hidden."""
    seed = unseal(sealed_path(root / case.name / TRAIN))["seed"]
    cutoff = diagnosis.split.recordings[0].cutoff
    with TemporaryDirectory() as folder:
        make(Path(folder), (), (), seed, setting_of(case))
        options = DiagnosisOptions(only=("rod_inertia",), cutoff=cutoff.hz if cutoff else None)
        twin = _diagnose(Path(folder), options).model
    return rms(twin.residuals, twin.split.test).tolist()
