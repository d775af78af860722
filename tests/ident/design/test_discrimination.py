"""Motions that tell effects apart."""

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


def told(*pair: str, on: Motion | None = None, joints: tuple[int, ...] = ()) -> dict[str, float]:
    on = on or motion()
    made = discrimination_model(simulated_rig(), [pair], library(), joints).at_rate(200.0).normalized_on(on)  # type: ignore[list-item]
    return made.discriminability(made.regressor(on))


def left(columns: Floats, which: list[int], rest: list[int]) -> float:
    """RMS of the columns `which` that those of `rest` leave, by least squares."""
    rows = columns.reshape(-1, columns.shape[2])
    solved = np.linalg.lstsq(rows[:, rest], rows[:, which], rcond=None)[0]
    return float(np.sqrt(((rows[:, which] - rows[:, rest] @ solved) ** 2).mean(axis=0).sum()))


def test_what_is_told_is_what_least_squares_leave() -> None:
    made = discrimination_model(simulated_rig(), [("arm_com_offset", "asymmetric_viscous")], library(), [1])
    columns, own = made.regressor(motion()), len(made.base.parameters)
    base, first, second = list(range(own)), [own + 1], [own + 4]
    expected = {
        "arm_com_offset": left(columns, first, [*base, own + 3, own + 4, own + 5]) / left(columns, first, base),
        "asymmetric_viscous": left(columns, second, [*base, own, own + 1, own + 2]) / left(columns, second, base),
    }
    strong = made.normalized_on(motion())
    assert strong.discriminability(strong.regressor(motion())) == pytest.approx(expected, rel=1e-3)


def test_what_is_alike_is_told_apart_worse() -> None:
    alike = told("joint_spring", "arm_com_offset")["arm_com_offset"]
    assert 0 <= alike < told("joint_spring", "asymmetric_viscous")["asymmetric_viscous"] <= 1
    assert alike < 0.05


def test_a_joint_that_is_known_is_told_no_worse_than_any() -> None:
    anywhere = told("joint_spring", "arm_com_offset")
    for joint in range(3):
        there = told("joint_spring", "arm_com_offset", joints=(joint,))
        assert all(there[name] >= anywhere[name] - 1e-9 for name in anywhere)


@pytest.mark.parametrize(
    "pair",
    [
        ("torque_gain_mismatch", "torque_map_exponent"),
        ("encoder_zero_offset", "geometry_error"),
        ("actuation_delay", "back_emf"),
    ],
)
def test_distortions_have_columns_too(pair: tuple[str, str]) -> None:
    assert all(0 < share <= 1 for share in told(*pair).values())


def test_one_that_contains_the_other_cannot_be_excluded_but_shown() -> None:
    assert list(told("joint_spring", "torque_offset")) == ["joint_spring"]


def test_a_recording_speaks_along_with_the_new_motion() -> None:
    alone = discrimination_model(simulated_rig(), [("joint_spring", "arm_com_offset")], library()).normalized_on(motion("fig5a"))
    beside = alone.with_recorded(motion("fig5a"))
    columns = alone.regressor(motion())
    less, more = alone.discriminability(columns), beside.discriminability(columns)
    assert all(more[name] > less[name] for name in less)


def test_effects_that_remember_know_the_rate() -> None:
    made = discrimination_model(simulated_rig(), [("actuation_delay", "back_emf")], library())

    def delayed(rate: float) -> Floats:
        rows = made.at_rate(rate).regressor(motion(rate=rate))[:: round(rate / 100)]
        return rows[20:-20, 0, len(made.base.parameters)]

    np.testing.assert_allclose(delayed(400.0), delayed(200.0), atol=0.05 * np.abs(delayed(200.0)).max())


def test_a_distortion_beyond_what_closes_is_looked_at_smaller() -> None:
    known = library()
    own = [replace(one, starts=(-0.6,)) for one in known["geometry_error"].parameters]  # type: ignore[attr-defined]
    short = {**known, "geometry_error": replace(known["geometry_error"], parameters=tuple(own))}  # type: ignore[call-arg]
    made, smaller = (
        discrimination_model(simulated_rig(), [("geometry_error", "stribeck")], effects).normalized_on(motion())
        for effects in (short, known)
    )
    found, expected = (one.regressor(motion())[:, :, len(one.base.parameters)] for one in (made, smaller))
    assert np.corrcoef(found.ravel(), expected.ravel())[0, 1] > 0.9


@pytest.mark.parametrize(
    ("rig", "pair", "found"),
    [
        (simulated_rig(), ("stribeck", "stribeck"), "two different"),
        (simulated_rig(), ("stribeck", "thermal_drift"), "depends on time"),
        (simulated_rig(), ("stribeck", "sponge"), "'sponge' found"),
        (AXES, ("stribeck", "air_drag"), "mechanism axes"),
        (simulated_rig(), ("stribeck", "amplifier_deadband"), "recordings of this rig can show expected: .*motor"),
    ],
)
def test_what_no_motion_tells_apart_is_refused(rig: Rig, pair: tuple[str, str], found: str) -> None:
    with pytest.raises(BadInput, match=found):
        discrimination_model(rig, [pair], library())


def test_a_joint_that_is_not_there_is_refused() -> None:
    with pytest.raises(BadInput, match="joint 1 to 3 expected, 4 found"):
        discrimination_model(simulated_rig(), [("stribeck", "cogging")], library(), [3])


def test_what_needs_a_load_asks_for_a_recording() -> None:
    made = discrimination_model(AXES, [("stribeck", "torque_gain_mismatch")], library())
    turning = np.sin(np.linspace(0, 6, 50))[:, None] * np.ones(2)
    with pytest.raises(BadInput, match="--recording"):
        made.normalized_on(Motion(turning, turning, turning, turning))


def design(*arguments: object) -> Result:
    return CliRunner().invoke(program, ["design", *map(str, arguments), "--json"], catch_exceptions=True)


@pytest.mark.slow
@pytest.mark.parametrize("beside", [[], ["--recording", SAMPLES / "fig5a.mcap", "--joint", 2]], ids=["", "beside"])
def test_the_designed_motion_tells_them_apart_better(tmp_path: Path, beside: list[object]) -> None:
    out = tmp_path / "next.toml"
    result = design("--discriminate", "joint_spring", "arm_com_offset", "--harmonics", "2", *beside, "-o", out)
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    before, after = found["before"]["told_apart"], found["after"]["told_apart"]
    assert after["arm_com_offset"] > 3 * before["arm_com_offset"]
    assert max(found["after"]["limits"].values()) < 0.951
    assert out.exists()


@pytest.mark.slow
def test_a_search_that_leaves_the_workspace_comes_back(tmp_path: Path) -> None:
    pair = ("--discriminate", "encoder_zero_offset", "torque_map_exponent")
    result = design(*pair, "--harmonics", "2", "-o", tmp_path / "next.toml")
    assert result.exit_code == 0, result.output
    assert max(json.loads(result.stdout)["after"]["limits"].values()) < 0.951
