"""Limit checks: the error names the first instant, the joint, the value and the limit."""

import re
from typing import Any

import numpy as np
import pytest

from recordings.rig import Axis, Limits, Rig, simulated_rig
from trajectories import Trajectory, kinematics, load
from trajectories.checks import LimitExceeded, check, torque_estimate, usage
from trajectories.fourier import FourierSeries
from trajectories.trajectory import assemble

RIG = simulated_rig()


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    return load("fig5a", RIG)


def limited(**limits: Any) -> Rig:
    return RIG.model_copy(update={"limits": Limits(**limits)})


def refusal(trajectory: Trajectory, **limits: Any) -> tuple[str, float]:
    with pytest.raises(LimitExceeded) as caught:
        check(trajectory, limited(**limits))
    return str(caught.value), caught.value.time


def test_speed_error_names_joint_instant_value_limit_and_remedy(trajectory: Trajectory) -> None:
    message, time = refusal(trajectory, speed=3.0)
    row = int(np.argmax((np.abs(trajectory.joint_velocity) > 3.0).any(axis=1)))
    joint = int(np.argmax(np.abs(trajectory.joint_velocity[row]))) + 1
    value = trajectory.joint_velocity[row, joint - 1]
    assert time == trajectory.time[row]
    assert message == (
        f"fig5a, t = {time:.3f} s: joint {joint} speed within ±3 rad/s expected, {value:.4g} found; "
        "slow the motion down or change limits.speed in the rig file"
    )


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        ({"joint_min": -0.5}, r"joint \d angle between -0.5 and 1.4 rad expected, -0.5.* found; move the path"),
        ({"joint_max": 0.2}, r"joint \d angle between -1.2 and 0.2 rad expected, 0.\d+ found"),
        ({"acceleration": 20.0}, r"joint \d acceleration within ±20 rad/s\^2 expected"),
        ({"torque": 15.0}, r"estimated torque of joint \d within ±15 N m expected"),
        ({"workspace_radius": 0.2}, r"distance from the z axis between 0 and 0.2 m expected, 0.2"),
        ({"workspace_z": (-0.7, -0.45)}, r"platform height between -0.7 and -0.45 m expected, -0.7"),
        ({"singularity_margin": 0.75}, r"singularity margin at least 0.75 expected, 0.\d+ found"),
    ],
)
def test_each_violated_limit_is_reported(trajectory: Trajectory, limits: dict[str, Any], words: str) -> None:
    message, _ = refusal(trajectory, **limits)
    assert re.search(words, message)
    assert all(name in message for name in limits)


def test_earliest_of_several_violations_is_reported(trajectory: Trajectory) -> None:
    _, speed = refusal(trajectory, speed=3.0)
    _, radius = refusal(trajectory, workspace_radius=0.2)
    message, both = refusal(trajectory, speed=3.0, workspace_radius=0.2)
    assert both == min(speed, radius)
    assert ("speed" in message) == (speed < radius)


def test_torque_estimate_at_rest_is_the_gradient_of_the_potential_energy(trajectory: Trajectory) -> None:
    nominal, geometry = RIG.nominal, RIG.geometry

    def potential(theta: np.ndarray) -> float:
        height = kinematics.forward(geometry, theta[None])[0, 2]
        elbows = geometry.L1 * np.sin(theta)
        arms = nominal.m_a * nominal.L1c * np.sin(theta)
        # A forearm's centre of mass is halfway between elbow and platform: exactly half its weight at either end.
        forearms = nominal.m_d * (elbows + height) / 2
        return float(9.81 * (nominal.m_p * height + arms.sum() + forearms.sum()))

    theta = trajectory.joint_position[0]
    step = 1e-5 * np.eye(3)
    gradient = [(potential(theta + row) - potential(theta - row)) / 2e-5 for row in step]
    assert torque_estimate(trajectory, RIG)[0] == pytest.approx(gradient, abs=1e-6)


def test_torque_estimate_does_no_net_work_over_a_cycle(trajectory: Trajectory) -> None:
    """Over one closed repetition a frictionless robot needs no net work."""
    cycle = trajectory.repeat == 1
    power = (torque_estimate(trajectory, RIG) * trajectory.joint_velocity).sum(axis=1)[cycle]
    assert abs(power.mean()) < 1e-6 * np.abs(power).max()


def test_usage_is_one_where_a_limit_is_reached(trajectory: Trajectory) -> None:
    within = usage(trajectory, RIG)
    fastest = float(np.abs(trajectory.joint_velocity).max())
    assert within["speed"].max() == pytest.approx(fastest / RIG.limits.speed)
    assert max(values.max() for values in within.values()) < 1
    assert usage(trajectory, limited(speed=fastest))["speed"].max() == pytest.approx(1)
    margin = float(kinematics.singularity_margin(RIG.geometry, trajectory.joint_position, trajectory.platform).min())
    assert usage(trajectory, limited(singularity_margin=margin))["singularity_margin"].max() == pytest.approx(1)


def test_axes_rig_is_checked_against_joint_limits_only() -> None:
    rig = Rig(name="bench", mechanism="axes", axes=(Axis(type="prismatic"),), limits=Limits(speed=0.5))
    series = FourierSeries(kind="fourier", space="joint", period=2.0, centre=(0.1,), cosine=((0.0,),), sine=((0.2,),))
    trajectory = assemble(series.motion("wave"), rig)
    assert trajectory.joint_position.shape[1] == 1
    assert np.isnan(trajectory.platform).all()
    assert set(usage(trajectory, rig)) == {"joint_min or joint_max", "speed", "acceleration"}
    with pytest.raises(LimitExceeded, match=r"joint 1 speed within ±0\.5 m/s expected"):
        check(trajectory, rig)
