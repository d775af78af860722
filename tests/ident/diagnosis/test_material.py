"""What a diagnosis works with."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import convolve2d

from ident.diagnosis import split_data
from ident.diagnosis.split_data import SplitData, rms
from ident.dynamics.effects.library import library


def test_errors_in_a_regressor_make_a_fit_believe_it_less() -> None:
    rng = np.random.default_rng(0)
    read = rng.normal(size=(20_000, 1, 1))
    other = read + 0.5 * rng.normal(size=read.shape)
    seen = np.ones((len(read), 1), bool)
    of = [SimpleNamespace(linearised=lambda bare, x, columns=columns: (None, columns)) for columns in (read, other)]
    made: Any = SplitData((of[0],), (seen,), (~seen,), (np.where(seen, 3.0, 0.0),), True)  # type: ignore[arg-type]
    made.__dict__["disturbed"] = (of[1],)
    columns, misled = made.misread(SimpleNamespace(terms=(), named=(None,)))
    assert columns == [(read, other)]
    # -E[other (other - read)] / E[other^2]
    assert misled == pytest.approx(-0.25 / 1.25, rel=0.05)


def _with_signal(amplified: float, share: float) -> tuple[Any, Any]:
    """Of one joint, in which a `share` of the rows amplifies errors so many times; and a solution."""
    size = np.where(np.arange(1000) < 1000 * share, amplified, 1.0)[:, None]
    course = SimpleNamespace(condition=lambda signal: signal)
    evaluator: Any = SimpleNamespace(course=course, amplification=lambda composition, x, error: size)
    every = np.ones((1000, 1), bool)
    made = SplitData((evaluator, evaluator), (every, ~every), (~every, every), (every * 1.0, every * 0.0), True)
    term = SimpleNamespace(effect=library()["amplifier_saturation"])
    return made, SimpleNamespace(composition=SimpleNamespace(terms=(term,)), x=np.zeros(1))


def test_rows_whose_voltage_tells_little_of_the_torque_are_not_judged_but_seen_by_fits() -> None:
    all_rows, solution = _with_signal(amplified=5.0, share=0.1)
    told = all_rows.faithful(solution, np.ones(1))
    assert told.silent == pytest.approx(0.1)
    assert [int(rows.sum()) for rows in (told.seen[0], told.held[1])] == [900, 900]
    assert told.weights is all_rows.weights


@pytest.mark.parametrize(("amplified", "share"), [(1.5, 0.5), (5.0, 0.005)])
def test_a_little_amplification_or_hardly_any_rows_of_it_change_nothing(amplified: float, share: float) -> None:
    all_rows, solution = _with_signal(amplified, share)
    assert all_rows.faithful(solution, np.ones(1)) is all_rows


def test_rows_of_which_the_model_says_nothing_do_not_count() -> None:
    residual = np.array([[3.0], [np.nan], [4.0], [9.0]])
    chosen = np.array([[True], [True], [True], [False]])
    assert rms([residual], [chosen]) == pytest.approx(np.sqrt(12.5))


def test_a_joint_that_creeps_stands_still_and_one_that_reverses_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    time = np.arange(0.0, 4.0, 1 / 500)
    reverses, touches = np.sin(2 * np.pi * time), 1 + np.cos(np.pi * time)  # the latter at 1 s and 3 s
    taps = np.full((17, 1), 1 / 17)
    course: Any = SimpleNamespace(
        path=SimpleNamespace(motion=SimpleNamespace(velocity=np.stack([reverses, touches], axis=1))),
        condition=lambda x: convolve2d(x, taps, "same"),
    )
    monkeypatch.setattr(split_data, "_perturbed", lambda course: course)
    still = split_data.standstill_share(course) > split_data.MAX_STANDSTILL
    assert not still[:, 0].any()
    around = np.abs(time % 2 - 1)
    assert still[around < 0.05, 1].all()
    assert not still[around > 0.1, 1].any()
