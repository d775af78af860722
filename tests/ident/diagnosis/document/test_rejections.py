"""Reasons why effects are not among the findings."""

from types import SimpleNamespace
from typing import Any

import pytest

from ident.diagnosis.document.rejections import rejected_effects
from ident.dynamics.effects.library import library


@pytest.mark.parametrize(
    ("first", "last", "forced", "status", "expected"),
    [
        (0.4, 0.02, False, "absorbed", "only 2.0% beside stribeck"),
        (0.4, 0.39, False, "not-supported", "but the held-out data do not support it"),
        (0.0, 0.001, False, "not-supported", "hardly more than chance"),
        (0.9, 0.8, False, "not-supported", "80.0% of the remaining residual, but its strength is zero."),
        (0.99, 0.99, True, "not-supported", "It was not requested. It would explain 99.0%"),
    ],
)
def test_rejected_effect_has_a_reason(first: float, last: float, forced: bool, status: str, expected: str) -> None:
    before, after = (SimpleNamespace(loss_reductions={"cogging": share}) for share in (first, last))
    refused = {"cogging": "its strength is zero"} if last == 0.8 else {}
    after.excluded = {}
    finding = SimpleNamespace(term=SimpleNamespace(name="stribeck", effect=library()["stribeck"]))
    selection = SimpleNamespace(first_extensions=before, last_extensions=after, refused=refused, findings=(finding,))
    recording = SimpleNamespace(recording=SimpleNamespace(rig=SimpleNamespace(mechanism="axes")))
    diagnosis: Any = SimpleNamespace(
        selection=selection,
        forced=forced,
        library={"cogging": library()["cogging"]},
        effects=SimpleNamespace(unobservable={}, untested={}),
        split=SimpleNamespace(recordings=(recording,)),
        ripple=SimpleNamespace(lines=()),
    )
    (entry,) = rejected_effects(diagnosis)
    assert entry.status == status
    assert expected in entry.why
