"""What every effect must keep to."""

import numpy as np
import pytest

from ident import discovery, mechanisms
from ident.effects import load, with_effects
from ident.motion import Motion
from recordings.errors import BadInput
from recordings.imported import imported_rig

NAMES = discovery.names("effects")


@pytest.fixture(scope="module")
def motion() -> Motion:
    t = np.linspace(0, 2, 300)[:, None] + np.array([0.0, 0.4])
    velocity = 3 * np.cos(3 * t)
    position = np.sin(3 * t)
    position[5] = velocity[5] = np.nan
    return Motion(position, velocity, -9 * np.sin(3 * t), np.sign(velocity))


@pytest.mark.parametrize("name", NAMES)
def test_it_explains_itself(name: str) -> None:
    effect = load(name)
    for text in (effect.sentence, effect.equation, effect.causes, effect.remedy):
        assert text.strip()
    for coefficient in effect.coefficients:
        assert coefficient.name in effect.equation
        assert coefficient.meaning
        assert coefficient.unit.format(effort="N", position="m")


@pytest.mark.parametrize("name", NAMES)
def test_its_columns_fit_the_motion(name: str, motion: Motion) -> None:
    effect = load(name)
    columns = effect.columns(motion)
    assert columns.shape == (300, 2, len(effect.coefficients))
    assert np.isnan(columns[5]).all()
    assert np.isfinite(np.delete(columns, 5, axis=0)).all()


@pytest.mark.parametrize("name", NAMES)
def test_every_joint_has_its_own_coefficients(name: str, motion: Motion) -> None:
    rig = imported_rig("bench", 2, 100.0, joints=("revolute", "prismatic"))
    base = mechanisms.create(rig)
    extended = with_effects(base, [name], rig)
    own = extended.parameters[len(base.parameters) :]
    c = len(load(name).coefficients)
    assert len(own) == 2 * c
    assert all(parameter.name.startswith(f"{name}.") for parameter in own)
    assert not any("{" in parameter.unit for parameter in own)
    columns = np.nan_to_num(extended.regressor(motion))
    np.testing.assert_array_equal(columns[:, :, : len(base.parameters)], np.nan_to_num(base.regressor(motion)))
    added = columns[:, :, len(base.parameters) :]
    for joint in (0, 1):
        others = np.delete(np.arange(2 * c), np.arange(c) + joint * c)
        assert added[:, joint].any()
        assert not added[:, joint, others].any()


def test_what_is_not_there_or_twice_is_refused() -> None:
    rig = imported_rig("bench", 2, 100.0)
    with pytest.raises(BadInput, match="torque_offset"):
        with_effects(mechanisms.create(rig), ["magic"], rig)
    with pytest.raises(BadInput, match="found twice"):
        with_effects(mechanisms.create(rig), ["torque_offset"] * 2, rig)
