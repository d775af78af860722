"""Effects that are asked for by name."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from ident.diagnosis.answer import _not_added, to_document
from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose
from ident.dynamics.effects.library import library
from recordings.errors import BadInput

SAMPLE = Path("recordings/samples/fig5a.mcap")


def test_a_name_that_is_none_is_refused_before_any_work() -> None:
    with pytest.raises(BadInput, match=r"one of .*air_drag.* expected, 'frobnicate' found"):
        diagnose([Path("no such file")], [], library(), DiagnosisOptions(only=("frobnicate",)))


def test_what_such_recordings_cannot_show_is_refused_with_the_reason() -> None:
    with pytest.raises(BadInput, match="can show expected, 'amplifier_saturation' found: "):
        diagnose([SAMPLE], [], library(), DiagnosisOptions(only=("amplifier_saturation",)))


@pytest.mark.parametrize(
    ("first", "last", "by_hand", "status", "expected"),
    [
        (0.4, 0.02, False, "absorbed", "once stribeck is in, 2.0%"),
        (0.4, 0.39, False, "not-supported", "does not bear it out"),
        (0.0, 0.001, False, "not-supported", "hardly more than chance"),
        (0.99, 0.99, True, "not-supported", "It was not asked for. It would explain 99.0%"),
    ],
)
def test_why_an_effect_was_not_added(first: float, last: float, by_hand: bool, status: str, expected: str) -> None:
    gains = (SimpleNamespace(gains={"cogging": share}) for share in (first, last))
    ladder = SimpleNamespace(**dict(zip(("first", "last"), gains, strict=True)))
    found: Any = SimpleNamespace(ladder=ladder, by_hand=by_hand)
    entry = _not_added(found, "cogging", ["stribeck"])
    assert entry.status == status
    assert expected in entry.why


@pytest.mark.slow
def test_what_is_asked_for_and_explains_nothing_is_not_missing() -> None:
    """The sample has nothing hidden that looks like it."""
    found = to_document(
        diagnose([SAMPLE], [SAMPLE.with_name("fig5b.mcap")], library(), DiagnosisOptions(only=("thermal_drift",)))
    )
    (asked,) = (one for one in found.findings if one.effect == "thermal_drift")
    assert asked.status == "not-supported"
    assert found.sentence.startswith("What was asked for explains nothing")
    assert found.verdict != "missing-effect"


def test_what_would_need_an_impossible_sign_is_refused_for_that() -> None:
    with pytest.raises(BadInput, match="'air_drag' is not there: it would need a sign that it cannot have"):
        diagnose([SAMPLE], [], library(), DiagnosisOptions(only=("air_drag",)))
