"""The answer to a diagnosis in sentences."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose
from ident.diagnosis.document.verdict import _sentence, _verdict, to_document
from ident.dynamics.effects.library import library

SAMPLE = Path("recordings/samples/fig5a.mcap")


@pytest.mark.parametrize(
    ("known", "significant", "expected"),
    [
        (True, False, "adequate"),
        (False, False, "undetermined"),
        (True, True, "unknown-structure"),
        (False, True, "unknown-structure"),
    ],
)
def test_nothing_found_is_adequate_only_above_a_known_floor(known: bool, significant: bool, expected: str) -> None:
    mandatory = SimpleNamespace(model=SimpleNamespace(terms=(), names=set()))
    diagnosis: Any = SimpleNamespace(
        selection=SimpleNamespace(findings=(), steps=(mandatory,)),
        forced=False,
        unexplained=SimpleNamespace(significant=significant, sentence="why."),
        model=SimpleNamespace(noise_floor=SimpleNamespace(known=known)),
        ripple=SimpleNamespace(lines=()),
    )
    assert _verdict(diagnosis) == expected
    claims_adequacy = "adequate" in _sentence(diagnosis, expected)  # type: ignore[arg-type]
    assert claims_adequacy == (expected == "adequate")


@pytest.mark.slow
def test_errors_on_all_rows_stand_beside_those_on_judged_rows() -> None:
    document = to_document(diagnose([SAMPLE], [], library(), DiagnosisOptions(only=("stribeck",))))
    for step in document.steps:
        assert len(step.train_rms_all) == len(step.held_out_rms_all) == 3
        assert step.train_rms_all == pytest.approx(step.train_rms, rel=0.2)


def test_forced_effect_that_explains_nothing_is_not_missing() -> None:
    """The sample has no such effect."""
    document = to_document(
        diagnose([SAMPLE], [SAMPLE.with_name("fig5b.mcap")], library(), DiagnosisOptions(only=("thermal_drift",)))
    )
    (finding,) = (finding for finding in document.findings if finding.effect == "thermal_drift")
    assert finding.status == "not-supported"
    assert document.sentence.startswith("The requested effects explain nothing")
    assert document.verdict != "missing-effect"
