"""The answer to a diagnosis in sentences."""

from pathlib import Path

import pytest

from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose
from ident.diagnosis.document.verdict import to_document
from ident.dynamics.effects.library import library

SAMPLE = Path("recordings/samples/fig5a.mcap")


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
    assert document.sentence.startswith("Held-out data do not confirm the requested effects (thermal_drift: gain ")
    assert document.verdict != "missing-effect"
