"""Which effects recordings can show: what is called visible is found, and what is not is not."""

from dataclasses import replace

import numpy as np
import pytest

from ident.diagnosis.split.observability import observability
from ident.diagnosis.visibility.visibility import EffectVisibility, VisibilityCheck
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.recording import Floats, Recording
from tests.ident import building

NOISE = 0.05
DEFAULT_SHARE = 0.03
COLUMNS = {
    "quadratic_friction": lambda motion: motion.velocity * np.abs(motion.velocity),
    "asymmetric_viscous": lambda motion: np.abs(motion.velocity),
    "torque_offset": lambda motion: np.ones_like(motion.velocity),
}


def check(recording: Recording, *names: str, share: float = DEFAULT_SHARE) -> dict[str, EffectVisibility]:
    data = building.split([recording])
    effects = {name: effect for name, effect in observability(data, library()).observable.items() if name in names}
    return {each.name: each for each in VisibilityCheck(building.fitted(data), effects).effects(share)}


def found(recording: Recording, name: str) -> list[str]:
    search, begin = building.search(building.split([recording]), {name: library()[name]})
    return [finding.term.name for finding in search.select(*begin).findings]


@pytest.mark.parametrize("name", COLUMNS)
def test_a_diagnosis_finds_what_is_larger_than_the_smallest_visible_size(name: str) -> None:
    best = check(building.record(noise=NOISE), name)[name].best
    assert best.possible
    assert 0 < best.smallest.share < DEFAULT_SHARE

    def hidden(factor: float) -> Recording:
        def torque(motion: Motion) -> Floats:
            return factor * best.smallest.value * np.asarray(COLUMNS[name](motion))

        return building.record(noise=NOISE, extra=torque)

    assert found(hidden(1.5), name) == [name]
    assert found(hidden(0.2), name) == []


def test_the_smallest_size_grows_with_the_noise_and_where_others_reproduce_it() -> None:
    """One direction does not show an offset."""
    quiet, loud = (
        check(building.record(noise=noise), "quadratic_friction")["quadratic_friction"].best for noise in (0.02, 0.2)
    )
    assert loud.smallest.share > 2 * quiet.smallest.share
    assert loud.outside == pytest.approx(quiet.outside, rel=0.01)
    offset = check(building.record(noise=NOISE, drift=20.0), "torque_offset")["torque_offset"]
    assert offset.best.smallest.share == np.inf
    assert not offset.visible_joints(1.0)


def test_each_joint_is_judged_by_itself() -> None:
    quiet = building.record(2, noise=NOISE)
    assert quiet.effort is not None
    noise = np.random.default_rng(1).normal(0, [0.0, 5.0], quiet.effort.shape)
    for recording, visible in ((quiet, [0, 1]), (replace(quiet, effort=quiet.effort + noise), [0])):
        visibility = check(recording, "quadratic_friction")["quadratic_friction"]
        assert [joint.joint for joint in visibility.visible_joints(DEFAULT_SHARE)] == visible


def test_effects_that_look_the_same_on_this_motion_imitate_each_other() -> None:
    names = ("axis_weight", "torque_offset", "quadratic_friction")
    small = check(building.record(noise=NOISE, size=0.05), *names, share=0.3)
    assert small["axis_weight"].imitations == ("torque_offset",)
    large = check(building.record(noise=0.01, size=1.5), *names)
    assert not large["axis_weight"].imitations


def test_an_effect_is_not_visible_at_a_size_that_hardware_never_has() -> None:
    visibility = check(building.record(noise=5.0), "encoder_eccentricity", share=1.0)["encoder_eccentricity"]
    assert not visibility.best.possible
    assert not visibility.visible_joints(1.0)
