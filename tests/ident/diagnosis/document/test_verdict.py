"""The answer to a diagnosis in sentences."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose
from ident.diagnosis.document.document import Verdict
from ident.diagnosis.document.verdict import conclusion, to_document
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


def concluded(
    error: float,
    torque: float = 5.0,
    structured: bool = False,
    found: bool = False,
    taken: float = 0.0,
    **fields: Any,
) -> Verdict:
    """The verdict on one joint with a noise floor of 0.1 N m, of which a correct model leaves 0.12 N m at most."""
    floor = SimpleNamespace(rms=np.array([0.1]), limit=np.array([0.12]))
    model = SimpleNamespace(
        judged_residuals=(np.array([[error]]),),
        noise_floor=floor,
        names=set(),
        improvement_over=lambda first: SimpleNamespace(share=taken),
    )
    diagnosis: Any = SimpleNamespace(
        model=model,
        split=SimpleNamespace(scored=(np.array([[True]]),), torque_rms=np.array([torque])),
        selection=SimpleNamespace(steps=[SimpleNamespace(model=model)]),
        ripple=SimpleNamespace(lines=()),
        unexplained=SimpleNamespace(significant=structured, sentence=""),
        library=library(),
        **{"forced": False, "data_problems": (), **fields},
    )
    missing: Any = [SimpleNamespace(effect="stribeck", joints=(1,), confusable_with=())] * found
    return conclusion(diagnosis, missing, missing)[0]


@pytest.mark.parametrize(
    ("left", "verdict"),
    [
        ({"error": 0.1}, "adequate"),
        ({"error": 0.1, "torque": 1.0}, "undetermined"),  # 3 % of the torque would not exceed the limit
        ({"error": 0.1, "found": True, "taken": 0.9}, "missing-effect"),
        ({"error": 0.1, "found": True, "taken": 0.09}, "missing-effect"),
        ({"error": 1.0, "found": True, "taken": 0.5}, "missing-effect"),
        ({"error": 1.0, "found": True, "taken": 0.09}, "unknown-structure"),  # a trifle beside a large remainder
        ({"error": 1.0}, "undetermined"),
        ({"error": 1.0, "structured": True}, "unknown-structure"),
        ({"error": 1.0, "structured": True, "found": True, "taken": 0.9}, "unknown-structure"),
    ],
)
def test_first_rule_that_applies_decides(left: dict[str, Any], verdict: Verdict) -> None:
    assert concluded(**left) == verdict
    problem = SimpleNamespace(blocks=True, why="The torque is noise.")
    assert concluded(**left, data_problems=(problem,)) == "implausible-data"
