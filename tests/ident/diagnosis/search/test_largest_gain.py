"""The bound of screening: no fit of an effect gains more on held-out rows than it says."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ident.diagnosis.judge.judge import judge
from ident.diagnosis.search.candidates import added_term
from ident.diagnosis.search.largest_gain import LargestGain
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building

TRIED = (
    "quadratic_friction",
    "joint_spring",
    "stribeck",
    "presliding_hysteresis",
    "actuation_delay",
    "thermal_drift",
)


@settings(max_examples=6, deadline=None, derandomize=True)
@given(
    order=st.floats(0.5, 6.0),
    size=st.floats(0.0, 0.1),
    level=st.floats(0.02, 0.2),
    seed=st.integers(0, 1000),
)
def test_no_effect_gains_more_than_its_bound(order: float, size: float, level: float, seed: int) -> None:
    """What is left is a wave over the angle, which none of the effects is, and of which each may take a part."""

    def wave(motion: Motion) -> Floats:
        torque: Floats = size * np.sin(order * motion.position + 1.0)
        return torque

    recordings = [building.record(noise=level, extra=wave, seed=each) for each in (seed, seed + 1)]
    data = building.split(recordings[:1], recordings[1:])
    search, begin = building.search(data, {name: library()[name] for name in TRIED})
    model, _ = search.start(*begin)
    largest = LargestGain(model)
    for name, candidate in search.candidates.screen(model).best.items():
        if search.candidates.is_significant(model, candidate):
            continue  # these are fitted and judged
        extended = search.add(model, name)
        evidence = judge(model, extended, added_term(model, extended)).evidence
        assert evidence.gain <= largest.of(candidate) + 0.02, name  # a shape that was fitted lies beside those tried


def test_bound_of_what_is_there_is_its_share() -> None:
    """Drag of a size that hides half of the excess: the bound is no more than chance above what it takes."""
    recordings = [building.record(noise=0.05, extra=building.drag, seed=seed) for seed in (1, 2)]
    data = building.split(recordings[:1], recordings[1:])
    search, begin = building.search(data, {name: library()[name] for name in ("quadratic_friction", "joint_spring")})
    model, _ = search.start(*begin)
    best, largest = search.candidates.screen(model).best, LargestGain(model)
    assert largest.of(best["quadratic_friction"]) == pytest.approx(1.0, abs=0.05)
    assert largest.of(best["joint_spring"]) < 0.3
