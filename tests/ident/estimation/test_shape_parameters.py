"""Shape and signal parameters of chosen effects, fitted before a linear estimator fits the others."""

import numpy as np
import pytest

from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure
from ident.estimation.shape_parameters import fit_shape_parameters
from recordings.recording import Floats
from tests.ident import building


def stribeck(motion: Motion) -> Floats:
    bump: Floats = 0.8 * np.exp(-((motion.velocity / 0.6) ** 2)) * motion.direction
    return bump


def fitted(*names: str, **options: object) -> tuple[ModelStructure, Floats]:
    recording = building.record(**options)  # type: ignore[arg-type]
    return fit_shape_parameters([building.prepared(recording)], building.structure(recording, *names).terms)


def test_without_effects_it_is_the_mechanism() -> None:
    structure, x = fitted(joints=2)
    assert structure.terms == ()
    np.testing.assert_allclose(x, building.parameters(2), rtol=0.01)


def test_shape_is_found_from_the_initial_guesses() -> None:
    structure, x = fitted("stribeck", extra=stribeck, noise=0.01)
    assert [term.name for term in structure.terms] == ["stribeck"]
    np.testing.assert_allclose(x, [*building.parameters(), 0.8, 0.6], rtol=0.03)


@pytest.mark.parametrize("names", [("stribeck", "joint_spring"), ("joint_spring", "stribeck")])
def test_order_of_the_effects_does_not_matter(names: tuple[str, str]) -> None:
    structure, x = fitted(*names, extra=lambda motion: stribeck(motion) + 1.2 * motion.position, noise=0.01)
    values = dict(zip((entry.name for entry in structure.parameters), x, strict=True))
    assert values["stribeck.v_s"] == pytest.approx(0.6, rel=0.03)
    assert values["joint_spring.k1"] == pytest.approx(1.2, rel=0.03)
