import math
from dataclasses import replace

import numpy as np
import pytest

from daq.feedforward.watch import OffsetWatch, measured_torque, probe_signal
from drivers.protocol import Power, Sample
from recordings.rig import simulated_rig

RIG = simulated_rig()
SAMPLE = Sample((0.0,) * 3, (1.0,) * 3, (0,) * 3, (0,) * 3, (Power.ON,) * 3, 0, None)


@pytest.mark.parametrize(
    ("offset", "torque", "error", "reason"),
    [
        *[(offset, torque, 0.0, None) for offset, torque in ((7, 7), (4, 7), (12, 7), (-1, 7), (1.5, 0), (0, 20))],
        *[(offset, torque, 0.0, "works against the drive") for offset, torque in ((-7, 7), (20, 7), (-5, 0))],
        (2.0, 2.0, 0.024, None),
        (2.0, 2.0, -0.027, "following error 0.0250 rad (RMS over 0.1 s) with a torque offset of 2.0 N m"),
        (0.5, 1.0, 0.027, None),
        (-20.0, math.nan, math.nan, None),
    ],
)
def test_offset_ends_the_run_where_it_makes_things_worse(
    offset: float, torque: float, error: float, reason: str | None
) -> None:
    watch = OffsetWatch(RIG)
    reasons = [each for _ in range(125) if (each := watch.check(1, offset, torque, error))]
    assert reason in reasons[0] if reason else not reasons


def test_one_late_target_does_not_end_the_run() -> None:
    watch = OffsetWatch(RIG)
    assert not any(watch.check(0, 7.0, 7.0, 0.04 if k < 10 else 0.001) for k in range(50))


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


FOLLOWS_NOT = "joint 2: the drive does not follow its torque offset"


@pytest.mark.parametrize("sooner", [0, 1])
@pytest.mark.parametrize(
    ("answer", "known", "reason"),
    [
        (0.4, 1.0, "None"),
        (1.5, 1.0, "None"),
        (0.0, 1.0, FOLLOWS_NOT),
        (-1.0, 1.0, FOLLOWS_NOT),
        (3.0, 1.0, FOLLOWS_NOT),
        (1.0, 0.2, "joint 1: its torque is known in"),
    ],
)
def test_drive_that_does_not_follow_the_probe_is_named(answer: float, known: float, reason: str, sooner: int) -> None:
    assert str(_judge((1.0, answer, 1.0), known, sooner)).startswith(reason)
