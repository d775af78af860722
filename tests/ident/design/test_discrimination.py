"""Torque of effects in motions that have not been recorded, and how well a motion discriminates them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from ident.design.discrimination import discrimination_model
from ident.design.model import DesignModel, mandatory_effects, with_effects
from ident.design.motions import repeated_motion
from ident.dynamics.effects.library import library, load
from ident.dynamics.motion import Motion
from ident.dynamics.structure import Term
from ident.program import program
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Axis, Rig, simulated_rig
from trajectories import library as trajectories
from trajectories.checks import nominal_parameters

BENCH = Rig(name="bench", mechanism="axes", axes=(Axis(),))
INERTIA, VISCOUS = 0.4, 0.8


def wave(n: int = 400, rate: float = 200.0) -> Motion:
    time = np.arange(n)[:, None] / rate
    position, velocity = np.sin(3 * time), 3 * np.cos(3 * time)
    return Motion(position, velocity, -9 * position, np.sign(velocity))


def bench_model() -> DesignModel:
    return with_effects(BENCH, []).with_parameters(np.array([INERTIA, VISCOUS, 0.0]))


def test_columns_of_an_eccentric_encoder_are_those_of_position_velocity_and_acceleration() -> None:
    """True position q - a sin q: velocity changes by -a cos q q', acceleration by a (sin q q'^2 - cos q q'')."""
    motion = wave()
    columns = bench_model().columns(
        Term.on_all_joints("encoder_eccentricity", load("encoder_eccentricity"), BENCH), motion
    )
    q, velocity, acceleration = motion.position, motion.velocity, motion.acceleration
    expected = INERTIA * (np.sin(q) * velocity**2 - np.cos(q) * acceleration) - VISCOUS * np.cos(q) * velocity
    np.testing.assert_allclose(columns[:, :, 0], expected, atol=5e-3 * np.abs(expected).max())


def test_regressor_has_the_effects_behind_the_mechanism() -> None:
    model = with_effects(BENCH, ["quadratic_friction"])
    motion = wave()
    regressor = model.regressor(motion)
    assert [parameter.name for parameter in model.parameters] == ["I_1", "c_v1", "c_c1", "quadratic_friction.a1"]
    np.testing.assert_allclose(regressor[:, :, 3], motion.velocity * np.abs(motion.velocity))


def test_masses_of_the_rig_file_are_the_load() -> None:
    rig = simulated_rig()
    model = with_effects(rig, mandatory_effects(rig))
    by_name = dict(zip((parameter.name for parameter in model.parameters), model.values, strict=False))
    m_p, T_g, inertia = nominal_parameters(rig)
    assert (by_name["m_p"], by_name["T_g"], by_name["I_2"], by_name["c_v1"]) == (m_p, T_g, inertia, 0.0)


@pytest.mark.parametrize(
    ("effects", "message"),
    [
        (["stribeck", "stribeck"], "found twice"),
        (["back_emf"], "adds torque"),
        (["thermal_drift"], "does not change"),
    ],
)
def test_effects_that_are_no_torque_of_the_motion_are_refused(effects: list[str], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        with_effects(BENCH, effects)


SAMPLES = Path(__file__).parents[3] / "recordings" / "samples"
AXES = Rig(name="bench", mechanism="axes", axes=(Axis(), Axis()))


def motion(name: str = "excitation", rate: float = 200.0) -> Motion:
    return repeated_motion(trajectories.load(name, simulated_rig(), 1, rate))


def discriminability(*pair: str, on: Motion | None = None, joints: tuple[int, ...] = ()) -> dict[str, float]:
    on = on or motion()
    model = discrimination_model(simulated_rig(), [pair], library(), joints).at_rate(200.0).normalized_on(on)  # type: ignore[list-item]
    return model.discriminability(model.regressor(on))


def unexplained(columns: Floats, target: list[int], explaining: list[int]) -> float:
    """RMS of the columns `target` that the columns `explaining` leave in a least-squares fit."""
    rows = columns.reshape(-1, columns.shape[2])
    solution = np.linalg.lstsq(rows[:, explaining], rows[:, target], rcond=None)[0]
    return float(np.sqrt(((rows[:, target] - rows[:, explaining] @ solution) ** 2).mean(axis=0).sum()))


def test_discriminability_is_the_residual_of_least_squares() -> None:
    model = discrimination_model(simulated_rig(), [("arm_com_offset", "asymmetric_viscous")], library(), [1])
    columns, k = model.regressor(motion()), len(model.base.parameters)
    base, first, second = list(range(k)), [k + 1], [k + 4]
    expected = {
        "arm_com_offset": unexplained(columns, first, [*base, k + 3, k + 4, k + 5])
        / unexplained(columns, first, base),
        "asymmetric_viscous": unexplained(columns, second, [*base, k, k + 1, k + 2])
        / unexplained(columns, second, base),
    }
    normalized = model.normalized_on(motion())
    assert normalized.discriminability(normalized.regressor(motion())) == pytest.approx(expected, rel=1e-3)


def test_similar_effects_are_discriminated_worse_and_a_known_joint_helps() -> None:
    similar = discriminability("joint_spring", "arm_com_offset")
    other = discriminability("joint_spring", "asymmetric_viscous")["asymmetric_viscous"]
    assert 0 <= similar["arm_com_offset"] < 0.05 < other <= 1
    for joint in range(3):
        at_joint = discriminability("joint_spring", "arm_com_offset", joints=(joint,))
        assert all(at_joint[name] >= similar[name] - 1e-9 for name in similar)


@pytest.mark.parametrize(
    "pair",
    [
        ("torque_gain_mismatch", "torque_map_exponent"),
        ("encoder_zero_offset", "geometry_error"),
        ("actuation_delay", "back_emf"),
    ],
)
def test_signal_effects_are_discriminated(pair: tuple[str, str]) -> None:
    assert all(0 < share <= 1 for share in discriminability(*pair).values())


def test_an_effect_contained_in_the_alternative_is_not_evaluated() -> None:
    assert list(discriminability("joint_spring", "torque_offset")) == ["joint_spring"]


def test_a_recorded_motion_adds_to_the_discriminability() -> None:
    alone = discrimination_model(simulated_rig(), [("joint_spring", "arm_com_offset")], library()).normalized_on(
        motion("fig5a")
    )
    combined = alone.with_recorded(motion("fig5a"))
    columns = alone.regressor(motion())
    before, after = alone.discriminability(columns), combined.discriminability(columns)
    assert all(after[name] > before[name] for name in before)


def test_effects_with_memory_use_the_sample_rate() -> None:
    model = discrimination_model(simulated_rig(), [("actuation_delay", "back_emf")], library())

    def delayed(rate: float) -> Floats:
        rows = model.at_rate(rate).regressor(motion(rate=rate))[:: round(rate / 100)]
        return rows[20:-20, 0, len(model.base.parameters)]

    np.testing.assert_allclose(delayed(400.0), delayed(200.0), atol=0.05 * np.abs(delayed(200.0)).max())


def test_a_distortion_with_which_the_mechanism_does_not_close_is_reduced() -> None:
    effects = library()
    parameters = [replace(entry, initial_guesses=(-0.6,)) for entry in effects["geometry_error"].parameters]  # type: ignore[attr-defined]
    changed = {**effects, "geometry_error": replace(effects["geometry_error"], parameters=tuple(parameters))}  # type: ignore[call-arg]
    large, small = (
        discrimination_model(simulated_rig(), [("geometry_error", "stribeck")], available).normalized_on(motion())
        for available in (changed, effects)
    )
    actual, expected = (model.regressor(motion())[:, :, len(model.base.parameters)] for model in (large, small))
    assert np.corrcoef(actual.ravel(), expected.ravel())[0, 1] > 0.9


DELTA = simulated_rig()


@pytest.mark.parametrize(
    ("rig", "pair", "joints", "message"),
    [
        (DELTA, ("stribeck", "stribeck"), (), "two different"),
        (DELTA, ("stribeck", "thermal_drift"), (), "depends on time"),
        (DELTA, ("stribeck", "sponge"), (), "'sponge' found"),
        (AXES, ("stribeck", "air_drag"), (), "mechanism axes"),
        (DELTA, ("stribeck", "amplifier_deadband"), (), "observable in recordings of this rig expected: .*motor"),
        (DELTA, ("stribeck", "cogging"), (3,), "joint 1 to 3 expected, 4 found"),
        (AXES, ("stribeck", "torque_gain_mismatch"), (), "--recording"),  # it needs a load
    ],
)
def test_effects_that_no_motion_discriminates_are_refused(
    rig: Rig, pair: tuple[str, str], joints: tuple[int, ...], message: str
) -> None:
    turning = np.sin(np.linspace(0, 6, 50))[:, None] * np.ones(2)
    with pytest.raises(BadInput, match=message):
        discrimination_model(rig, [pair], library(), joints).normalized_on(Motion(*[turning] * 4))


def design(*arguments: object) -> Result:
    return CliRunner().invoke(program, ["design", *map(str, arguments), "--json"], catch_exceptions=True)


@pytest.mark.slow
@pytest.mark.parametrize("extra", [[], ["--recording", SAMPLES / "fig5a.mcap", "--joint", 2]], ids=["", "recording"])
def test_the_designed_motion_discriminates_better(tmp_path: Path, extra: list[object]) -> None:
    out = tmp_path / "next.toml"
    result = design("--discriminate", "joint_spring", "arm_com_offset", "--harmonics", "2", *extra, "-o", out)
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    before, after = document["before"]["discrimination"], document["after"]["discrimination"]
    assert after["arm_com_offset"] > 3 * before["arm_com_offset"]
    assert max(document["after"]["limits"].values()) < 0.951
    assert out.exists()


@pytest.mark.slow
def test_a_search_that_leaves_the_workspace_returns(tmp_path: Path) -> None:
    pair = ("--discriminate", "encoder_zero_offset", "torque_map_exponent")
    result = design(*pair, "--harmonics", "2", "-o", tmp_path / "next.toml")
    assert result.exit_code == 0, result.output
    assert max(json.loads(result.stdout)["after"]["limits"].values()) < 0.951
