"""Motions that tell two effects apart."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from ident.cli import program
from ident.design.rivals import rivals
from ident.effects import load
from ident.motion import Motion
from ident.signals import mean_sign
from recordings.errors import BadInput
from recordings.rig import simulated_rig
from trajectories import library


def _share(first: str, second: str) -> float:
    rig = simulated_rig()
    motion = library.load("excitation", rig, 1, 200.0)
    direction = np.nan_to_num(mean_sign(motion.joint_velocity))
    found = rivals(rig, (first, second), (load(first), load(second)))
    columns = found.regressor(
        Motion(motion.joint_position, motion.joint_velocity, motion.joint_acceleration, direction)
    )
    rows = columns.reshape(1, -1, columns.shape[2])
    return float(found.separation(rows / np.sqrt((rows**2).mean(axis=1, keepdims=True)))[0].min())


def test_what_is_alike_is_told_apart_worse() -> None:
    alike = _share("joint_spring", "arm_com_offset")
    assert 0 <= alike < _share("joint_spring", "asymmetric_viscous") <= 1
    assert alike < 0.01


def test_distortions_have_columns_too() -> None:
    assert 0 <= _share("torque_gain_mismatch", "torque_map_exponent") <= 1
    assert 0 <= _share("encoder_zero_offset", "geometry_error") <= 1


@pytest.mark.parametrize(
    ("names", "found"),
    [(("stribeck", "stribeck"), "two different"), (("stribeck", "thermal_drift"), "depends on time")],
)
def test_what_no_motion_tells_apart_is_refused(names: tuple[str, str], found: str) -> None:
    with pytest.raises(BadInput, match=found):
        rivals(simulated_rig(), names, (load(names[0]), load(names[1])))


@pytest.mark.slow
def test_the_designed_motion_tells_them_apart_better(tmp_path: Path) -> None:
    out = tmp_path / "next.toml"
    arguments = [
        "design",
        "--discriminate",
        "joint_spring",
        "arm_com_offset",
        "--harmonics",
        "3",
        "-o",
        str(out),
        "--json",
    ]
    result = CliRunner().invoke(program, arguments, catch_exceptions=False)
    found = json.loads(result.stdout)
    assert min(found["after"]["told_apart"]) > min(found["before"]["told_apart"])
    assert out.exists()
