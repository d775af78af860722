import pytest

from drivers.simulated.config import EffectSpec, SimConfig
from drivers.simulated.effect import build
from drivers.simulated.sizing import Ruler, resolve
from recordings.errors import BadInput
from recordings.rig import simulated_rig

RIG = simulated_rig()


@pytest.fixture(scope="module")
def ruler() -> Ruler:
    return Ruler(RIG, SimConfig())


@pytest.mark.slow
def test_nothing_has_no_size(ruler: Ruler) -> None:
    assert ruler.size(build(EffectSpec(name="cogging")).scaled(0.0)) < 1e-4


def test_cogging_is_left_whole(ruler: Ruler) -> None:
    """A ripple that no base column resembles, slow enough to pass: its size is its RMS over the torque's."""
    cogging = build(EffectSpec(name="cogging", parameters={"a": 0.5, "N": 15.0}))
    assert ruler.size(cogging) == pytest.approx(0.5 / 2**0.5 / 10.5, rel=0.1)


@pytest.mark.slow
def test_tilt_is_partly_absorbed_and_grows_in_proportion(ruler: Ruler) -> None:
    small, large = (ruler.size(build(EffectSpec(name="base_tilt", parameters={"angle": a}))) for a in (0.02, 0.04))
    assert large == pytest.approx(2 * small, rel=0.01)


@pytest.mark.slow
def test_payload_change_counts_wherever_it_happens(ruler: Ruler) -> None:
    early, late = (EffectSpec(name="payload_change", parameters={"t_c": t}) for t in (0.0, 1000.0))
    assert ruler.size(build(early)) == ruler.size(build(late)) > 0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "joints", "sign", "wanted"),
    [
        ("torque_offset", (2,), -1.0, 0.02),
        ("joint_elasticity", (1, 3), 1.0, 0.015),
        ("stribeck", (1, 2, 3), 1.0, 0.01),
    ],
)
def test_asked_size_is_found(ruler: Ruler, name: str, joints: tuple[int, ...], sign: float, wanted: float) -> None:
    effect = build(EffectSpec(name=name, joints=joints))
    found, size = ruler.nearest(effect.scaled(sign * effect.model_dump()[effect.strength()]), wanted)
    assert size == pytest.approx(wanted, rel=0.02)
    assert ruler.size(found) == pytest.approx(size, rel=1e-6)
    assert found.joints == joints
    assert sign * found.model_dump()[found.strength()] > 0


@pytest.mark.slow
def test_resolved_machine_has_parameters_and_no_sizes() -> None:
    offset = EffectSpec(name="torque_offset", joints=(1,), size=0.01)
    tilt = EffectSpec(name="base_tilt", parameters={"angle": 0.01})
    resolved = resolve(RIG, SimConfig(effects=(offset, tilt)))
    assert resolved.effects[0].size is None
    assert resolved.effects[0].parameters["a"] == pytest.approx(0.16, rel=0.1)
    assert resolved.effects[1] == tilt
    assert resolve(RIG, resolved) is resolved


@pytest.mark.parametrize(
    ("spec", "complaint"),
    [
        (EffectSpec(name="cogging", size=0.01, parameters={"a": 0.1}), "a size or 'a' expected, both found"),
        (EffectSpec(name="coging", size=0.01), "'coging' found"),
    ],
)
def test_bad_size_is_explained(spec: EffectSpec, complaint: str) -> None:
    with pytest.raises(BadInput, match=complaint):
        resolve(RIG, SimConfig(effects=(spec,)))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["backlash", "joint_elasticity"])
def test_size_out_of_reach_is_explained(name: str) -> None:
    huge = EffectSpec(name=name, joints=(1,), size=0.5)
    with pytest.raises(BadInput, match=r"a size of 0.5 cannot be had on joints \[1\]"):
        resolve(RIG, SimConfig(effects=(huge,)))
