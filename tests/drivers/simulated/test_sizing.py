import pytest

from drivers.simulated.config import EffectSpec, SimConfig
from drivers.simulated.effect import build, discover
from drivers.simulated.sizing import EffectSizer, resolve
from recordings.errors import BadInput
from tests.drivers.simulated.swinging import RIG, reporting


@pytest.fixture(scope="module")
def sizer() -> EffectSizer:
    return EffectSizer(RIG, SimConfig())


def test_cogging_is_not_absorbed_by_the_base_model(sizer: EffectSizer) -> None:
    """A ripple below the bandwidth, unlike any base column: its size is its RMS over the torque's."""
    cogging = build(EffectSpec(name="cogging", parameters={"a": 0.5, "N": 15.0}))
    assert sizer.size(cogging) == pytest.approx(0.5 / 2**0.5 / 10.5, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["encoder_zero_offset", "torque_gain_mismatch", "back_emf", "geometry_error", "base_tilt"]
)
def test_size_is_proportional_to_strength(sizer: EffectSizer, name: str) -> None:
    """Twice the strength has twice the size."""
    effect = build(EffectSpec(name=name, joints=(2,) if not discover()[name].whole_robot else (1, 2, 3)))
    strength = effect.model_dump()[effect.strength()]
    small, large = (sizer.size(effect.scaled(share * strength)) for share in (0.5, 1.0))
    assert small > 0.0003
    assert large == pytest.approx(2 * small, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "visible"), [("motor", False), ("command", True)])
def test_dead_band_is_visible_only_in_the_command(kind: str, visible: bool) -> None:
    size = EffectSizer(reporting(kind), SimConfig()).size(build(EffectSpec(name="amplifier_deadband", joints=(2,))))
    assert (size > 0.005) == visible
    assert visible or size < 5e-4


def test_common_torque_gain_error_is_absorbed_by_the_base_model(sizer: EffectSizer) -> None:
    assert sizer.size(build(EffectSpec(name="torque_gain_mismatch", parameters={"mismatch": 0.2}))) < 1e-3


@pytest.mark.slow
def test_size_of_an_unstable_loop_is_infinite(sizer: EffectSizer) -> None:
    assert sizer.size(build(EffectSpec(name="actuation_delay", parameters={"delay": 0.01}))) == float("inf")


@pytest.mark.slow
def test_thermal_drift_is_measured_over_several_repetitions(sizer: EffectSizer) -> None:
    """A drift that ends within the first repetition has a small size."""
    slow, quick = (
        sizer.size(build(EffectSpec(name="thermal_drift", joints=(1,), parameters={"T": T}))) for T in (10.0, 0.3)
    )
    assert slow > 3 * quick


@pytest.mark.slow
def test_size_of_a_payload_change_does_not_depend_on_its_time(sizer: EffectSizer) -> None:
    early, late = (EffectSpec(name="payload_change", parameters={"t_c": t}) for t in (0.0, 1000.0))
    assert sizer.size(build(early)) == sizer.size(build(late)) > 0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "joints", "sign", "target_size"),
    [
        ("torque_offset", (2,), -1.0, 0.02),
        ("joint_elasticity", (1, 3), 1.0, 0.015),
        ("stribeck", (1, 2, 3), 1.0, 0.01),
    ],
)
def test_strength_of_a_requested_size_is_found(
    sizer: EffectSizer, name: str, joints: tuple[int, ...], sign: float, target_size: float
) -> None:
    effect = build(EffectSpec(name=name, joints=joints))
    scaled_effect, size = sizer.nearest(effect.scaled(sign * effect.model_dump()[effect.strength()]), target_size)
    assert size == pytest.approx(target_size, rel=0.02)
    assert sizer.size(scaled_effect) == pytest.approx(size, rel=1e-6)
    assert scaled_effect.joints == joints
    assert sign * scaled_effect.model_dump()[scaled_effect.strength()] > 0


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
    with pytest.raises(BadInput, match=r"a size of 0.5 is not possible on joints \[1\]"):
        resolve(RIG, SimConfig(effects=(huge,)))
