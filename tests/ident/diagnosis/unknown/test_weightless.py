"""Missing weight beside effects, where no mass is known."""

import pytest

import ident
from ident.diagnosis.document.result import DiagnosisResult

pytest.importorskip("pinocchio")

from tests.ident import arms

TRUE = arms.urdf(arms.LIFTING)
SAID = "Without weight the last model explains these data much better"


def diagnosed(weight: float, *only: str) -> DiagnosisResult:
    train, validate = (arms.record(TRUE, arms.without_masses(TRUE), seed=seed, weight=weight) for seed in (1, 2))
    return ident.diagnose(train, validate=validate, only=only)


def test_a_torque_without_weight_is_told_where_no_effect_explains_it() -> None:
    (warning,) = (text for text in diagnosed(0.0).document.warnings if text.startswith(SAID))
    assert "the drives may have taken gravity out" in warning
    assert not any(SAID in text for text in diagnosed(1.0).document.warnings)


def test_an_effect_that_missing_weight_explains_as_well_has_it_as_an_or() -> None:
    (finding,) = diagnosed(0.0, "base_tilt").findings
    assert finding.confusable_with == ("gravity-missing",)
    (finding,) = diagnosed(1.0, "base_tilt").findings
    assert finding.confusable_with == ()
