import math
from dataclasses import replace

import numpy as np
import pytest

from daq.feedforward.watch import OffsetWatch, measured_torque, probe_signal
from drivers.protocol import Power, Sample
from recordings.rig import simulated_rig

RIG = simulated_rig()
SAMPLE = Sample((0.0,) * 3, (1.0,) * 3, (0,) * 3, (0,) * 3, (Power.ON,) * 3, 0, None)


def _reason(offset: float, torque: float, error: float = 0.0) -> str | None:
    """Reason after a quarter of a second."""
    watch, reasons = OffsetWatch(RIG), []
    for _ in range(125):
        reasons.append(watch.check(1, offset, torque, error))
    return next((reason for reason in reasons if reason), None)


@pytest.mark.parametrize(
    ("offset", "torque"), [(7.0, 7.0), (4.0, 7.0), (12.0, 7.0), (-1.0, 7.0), (1.5, 0.0), (0.0, 20.0)]
)
def test_offset_that_helps_or_does_little_is_allowed(offset: float, torque: float) -> None:
    assert _reason(offset, torque) is None


@pytest.mark.parametrize(("offset", "torque"), [(-7.0, 7.0), (20.0, 7.0), (-5.0, 0.0)])
def test_offset_that_works_against_the_drive_ends_the_run(offset: float, torque: float) -> None:
    assert "works against the drive" in str(_reason(offset, torque))


def test_following_error_may_be_half_of_the_limit_with_an_offset() -> None:
    assert _reason(2.0, 2.0, 0.024) is None
    assert "following error 0.0250 rad (RMS over 0.1 s) with a torque offset of 2.0 N m" in str(
        _reason(2.0, 2.0, -0.027)
    )
    assert _reason(0.5, 1.0, 0.027) is None


def test_one_late_target_does_not_end_the_run() -> None:
    watch = OffsetWatch(RIG)
    assert not any(watch.check(0, 7.0, 7.0, 0.04 if k < 10 else 0.001) for k in range(50))


def test_lost_answers_are_not_judged() -> None:
    assert _reason(-20.0, math.nan, math.nan) is None


def test_torque_is_that_of_the_voltage_else_of_the_drive() -> None:
    sample = replace(SAMPLE, voltage=(-2.0, math.nan, math.nan), effort=(1.0, 3.0, 0.0))
    assert [measured_torque(RIG, sample, joint) for joint in (0, 1)] == [-4.0, 3.0]
    assert math.isnan(measured_torque(RIG, replace(sample, effort=None), 1))


def _judge(answer: tuple[float, float, float], known: float = 1.0, sooner: int = 0) -> str | None:
    """Judgement of drives that answer a share of the signal, some cycles `sooner`, besides 7 N m and noise."""
    watch, rng = OffsetWatch(RIG), np.random.default_rng(0)
    signal = probe_signal(RIG)
    for offset, followed in zip(signal, np.roll(signal, -sooner, axis=0), strict=True):
        torque = 7 + np.array(answer) * followed + rng.normal(0, 0.05, 3)
        volts = np.where(rng.random() < known, np.sqrt(torque), math.nan)
        watch.note_answer(replace(SAMPLE, voltage=tuple(volts.tolist())), offset)
    return watch.judge_answers()


def test_probe_is_small_and_leaves_no_momentum() -> None:
    signal = probe_signal(RIG)
    assert np.abs(signal).max() <= 0.05 * 20
    np.testing.assert_array_equal(signal[-1], 0)
    # Without friction: speed and way, in N m cycles and N m cycles^2.
    speed = np.cumsum(signal, axis=0)
    np.testing.assert_allclose(speed[-1], 0, atol=1e-12)
    assert np.abs(np.cumsum(speed, axis=0)).max() <= 2.0


@pytest.mark.parametrize("sooner", [0, 1])
def test_drives_that_follow_the_probe_pass(sooner: int) -> None:
    assert _judge((1.0, 0.4, 1.5), sooner=sooner) is None


@pytest.mark.parametrize("sooner", [0, 1])
@pytest.mark.parametrize("answer", [0.0, -1.0, 3.0])
def test_drive_that_does_not_follow_the_probe_is_named(answer: float, sooner: int) -> None:
    reason = str(_judge((1.0, answer, 1.0), sooner=sooner))
    assert reason.startswith("joint 2: the drive does not follow its torque offset")


def test_unknown_torque_cannot_be_watched() -> None:
    assert "send voltage or torque by PDO" in str(_judge((1.0, 1.0, 1.0), known=0.2))
