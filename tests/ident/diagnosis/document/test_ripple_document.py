"""Entries of the document about the band above the low-pass."""

from dataclasses import replace

import pytest

from ident.diagnosis.document.findings import above_low_pass, with_ripple
from ident.diagnosis.document.verdict import step_entry
from ident.diagnosis.ripple.ripple import Ripple
from tests.ident.diagnosis.ripple.test_ripple import found


@pytest.fixture(scope="module")
def ripple() -> Ripple:
    return found()


def test_step_adds_all_lines_with_parameters_and_intervals(ripple: Ripple) -> None:
    last = step_entry(None, ripple.model, ripple)
    step = step_entry("cogging", ripple.model, ripple, with_lines=True)
    assert step.effects == ("cogging",)
    assert step.parameters.keys() - last.parameters.keys() == {"cogging.a2", "cogging.b2", "cogging.N"}
    assert {name: step.parameters[name] for name in last.parameters} == last.parameters
    low, high = step.parameters["cogging.N"].ci95 or (0.0, 0.0)
    assert low < 160.0 < high
    assert step.held_out_rms[1] < last.held_out_rms[1]
    assert step.held_out_rms_all[1] < last.held_out_rms_all[1]


def test_finding_names_joint_and_order(ripple: Ripple) -> None:
    (finding,) = with_ripple([], ripple)
    assert (finding.effect, finding.joints, finding.confusable_with) == ("cogging", (2,), ())
    assert "joint 2: 159.99" in finding.why
    assert finding.evidence.gain > 0.3


def test_vibration_that_explains_as_much_is_said(ripple: Ripple) -> None:
    uncertain = replace(ripple, lines=(replace(ripple.lines[0], same_frequency=41.0),))
    (finding,) = with_ripple([], uncertain)
    assert finding.confusable_with == ("vibration",)
    assert "a vibration of 41 Hz" in finding.why


def test_finding_below_the_low_pass_is_joined(ripple: Ripple) -> None:
    (above,) = with_ripple([], ripple)
    below = above.model_copy(update={"joints": (1,), "why": "Below."})
    (joined,) = with_ripple([below], ripple)
    assert joined.joints == (1, 2)
    assert joined.why.startswith("Below. Above the low-pass")


def test_unexplained_share_is_stated(ripple: Ripple) -> None:
    entry = above_low_pass(ripple)
    assert entry is not None
    assert entry.unexplained_share[0] == pytest.approx(float(ripple.unexplained_share[0]))
    assert entry.why.startswith("Above the low-pass, up to 200 Hz")
    assert above_low_pass(replace(ripple, bands=(), lines=())) is None
