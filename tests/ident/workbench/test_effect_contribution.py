"""The share of a residual that a candidate effect would remove."""

import numpy as np

from ident.diagnosis.search.screening import Screener
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from ident.workbench.effect_contribution import EffectContribution
from recordings.recording import Floats
from tests.ident import building


def drag(motion: Motion) -> Floats:
    return 0.5 * motion.velocity * np.abs(motion.velocity)


def test_linear_effect_removes_what_the_refit_removes() -> None:
    """Also on the recording that the fit did not see."""
    train, other = building.record(2, noise=0.05, extra=drag), building.record(2, 3, shape=1, extra=drag, name="b")
    data = building.split([train], [other])
    model, refitted = building.fitted(data), building.fitted(data, "quadratic_friction")
    (candidate,), _ = Screener(data, model.solution).screen({"quadratic_friction": library()["quadratic_friction"]})
    removed = EffectContribution(data, model.solution).compute(candidate)
    for torque, before, after in zip(removed, model.residuals, refitted.residuals, strict=True):
        np.testing.assert_allclose(torque, before - after, atol=1e-6)


def test_signal_effect_removes_about_what_the_refit_removes() -> None:
    """A drive signal that is 4 ms early."""
    late = building.record(cycles=6, noise=0.01)
    assert late.effort is not None
    late.effort[:-1] = late.effort[1:]
    data = building.split([late])
    model = building.fitted(data)
    (candidate, *_), _ = Screener(data, model.solution).screen({"actuation_delay": library()["actuation_delay"]})
    (removed,) = EffectContribution(data, model.solution).compute(candidate)
    (before,) = model.residuals
    remaining = np.nanmean((before - removed)[data.scored[0]] ** 2)
    assert remaining < 0.3 * np.nanmean(before[data.scored[0]] ** 2)


def test_unknown_rows_stay_unknown() -> None:
    recording = building.record(noise=0.05, extra=drag)
    recording.position[600:610] = np.nan
    data = building.split([recording])
    model = building.fitted(data)
    (candidate,), _ = Screener(data, model.solution).screen({"quadratic_friction": library()["quadratic_friction"]})
    (removed,) = EffectContribution(data, model.solution).compute(candidate)
    assert np.isnan(removed[300:305]).all()
