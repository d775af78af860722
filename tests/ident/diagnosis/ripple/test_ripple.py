"""Ripple above the low-pass of several joints."""

import numpy as np
import pytest

from ident.diagnosis.ripple.ripple import EFFECT, Ripple, find_ripple
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building


def ripple_of_second_joint(motion: Motion) -> Floats:
    torque = np.zeros_like(motion.position)
    torque[:, 1] = 0.2 * np.sin(160.0 * motion.position[:, 1])
    return torque


def found(known: tuple[str, ...] = (), **options: float) -> Ripple:
    train, test = (
        building.record(2, noise=0.1, extra=ripple_of_second_joint, rate=500.0, shape=shape, seed=shape, **options)
        for shape in (0, 1)
    )
    effects = {name: effect for name, effect in library().items() if name not in known}
    return find_ripple(building.fitted(building.split([train], [test])), effects)


def test_lines_lower_the_held_out_error_of_their_joint_only() -> None:
    ripple = found()
    assert [line.joint for line in ripple.lines] == [1]
    before, after = (ripple.errors(ripple.model, lines)["held_out_rms"] for lines in (False, True))
    assert after[0] == before[0]
    assert after[1] < 0.8 * before[1]
    assert ripple.upper > ripple.low


def test_without_the_effect_in_the_library_nothing_is_named_and_the_share_is_larger() -> None:
    ripple, without = found(), found(known=(EFFECT,))
    assert without.lines == ()
    assert without.upper == without.low
    assert without.unexplained_share[1] > 1.2 * ripple.unexplained_share[1]


def test_structure_predicts_the_ripple() -> None:
    ripple = found()
    assert [term.name for term in ripple.structure.terms] == [EFFECT]
    assert ripple.structure.shape_values(0, ripple.x) == pytest.approx([160.0], abs=0.1)
    assert len(ripple.half_widths) == 3


def test_noise_above_the_low_pass_joins_the_floor_where_cycles_repeat() -> None:
    ripple = found()
    assert (ripple.with_noise(np.zeros(2)) > 0).all()
    orders, amplitude = ripple.order_spectrum(1, with_lines=False)
    assert orders[amplitude.argmax()] == pytest.approx(160.0, abs=1.0)
