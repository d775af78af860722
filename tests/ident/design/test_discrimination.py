"""Discrimination of effects by motions."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from ident.cli import program
from ident.design.discrimination import discrimination_model
from ident.design.motions import repeated_motion
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Axis, Rig, simulated_rig
from trajectories import library as trajectories

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


def test_similar_effects_are_discriminated_worse() -> None:
    similar = discriminability("joint_spring", "arm_com_offset")["arm_com_offset"]
    assert 0 <= similar < discriminability("joint_spring", "asymmetric_viscous")["asymmetric_viscous"] <= 1
    assert similar < 0.05


def test_discriminability_with_a_known_joint_is_not_lower() -> None:
    anywhere = discriminability("joint_spring", "arm_com_offset")
    for joint in range(3):
        at_joint = discriminability("joint_spring", "arm_com_offset", joints=(joint,))
        assert all(at_joint[name] >= anywhere[name] - 1e-9 for name in anywhere)


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


@pytest.mark.parametrize(
    ("rig", "pair", "message"),
    [
        (simulated_rig(), ("stribeck", "stribeck"), "two different"),
        (simulated_rig(), ("stribeck", "thermal_drift"), "depends on time"),
        (simulated_rig(), ("stribeck", "sponge"), "'sponge' found"),
        (AXES, ("stribeck", "air_drag"), "mechanism axes"),
        (
            simulated_rig(),
            ("stribeck", "amplifier_deadband"),
            "observable in recordings of this rig expected: .*motor",
        ),
    ],
)
def test_effects_that_no_motion_discriminates_are_refused(rig: Rig, pair: tuple[str, str], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        discrimination_model(rig, [pair], library())


def test_a_joint_that_does_not_exist_is_refused() -> None:
    with pytest.raises(BadInput, match="joint 1 to 3 expected, 4 found"):
        discrimination_model(simulated_rig(), [("stribeck", "cogging")], library(), [3])


def test_an_effect_that_needs_a_load_requires_a_recording() -> None:
    model = discrimination_model(AXES, [("stribeck", "torque_gain_mismatch")], library())
    turning = np.sin(np.linspace(0, 6, 50))[:, None] * np.ones(2)
    with pytest.raises(BadInput, match="--recording"):
        model.normalized_on(Motion(turning, turning, turning, turning))


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
