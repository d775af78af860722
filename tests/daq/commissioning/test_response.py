"""From `daq response` to `ident response`: hidden elasticity and delay are found."""

import math
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.config import Links
from recordings.rig import simulated_rig
from tests.conftest import Runner
from trajectories import kinematics
from trajectories.multisine import multisine

EFFECT = '[[effects]]\nname = "{}"\njoints = [1]\nparameters = {{ {} = {} }}\n'


def resonance(compliance: float) -> float:
    """Resonance of motor 1 against the arm and what hangs on it, the other motors at rest [Hz]."""
    rig, links = simulated_rig(), Links()
    pose, _, _ = multisine(rig, 1, 1e-9).sample(np.array([0.0]))
    theta = pose[0]
    platform = kinematics.platform_motion(rig.geometry, pose, 0 * pose, 0 * pose)[3][0][:, 0]
    phi, L1 = rig.geometry.phi[0], rig.geometry.L1
    outwards = np.array([math.cos(phi), math.sin(phi), 0.0])
    elbow = L1 * (math.cos(theta[0]) * np.array([0, 0, 1.0]) - math.sin(theta[0]) * outwards)
    arm = links.arm_inertia + links.arm_mass * links.arm_com**2
    # A uniform rod with the velocities b and c of its ends has the energy m (b.b + b.c + c.c) / 6.
    rods = links.rod_mass / 3 * (elbow @ elbow + elbow @ platform + 3 * platform @ platform)
    load = arm + rods + links.platform_mass * platform @ platform
    return math.sqrt((1 / links.motor_inertia + 1 / load) / compliance) / (2 * math.pi)


def measure(daq: Runner, ident: Runner, folder: Path, *effects: tuple[str, str, float]) -> dict[str, float]:
    (folder / "sim.toml").write_text("".join(EFFECT.format(*effect) for effect in effects))
    recorded = daq("response", "--joint", 1, "--sim", "sim.toml", "--cycles", 2, "--out", "joint1.mcap")
    assert recorded.code == 0, recorded.err
    assert "next: ident response joint1.mcap" in recorded.err
    done = ident("response", "joint1.mcap", "--json", "--plot", "bode.html", "-o", "response.csv")
    document: dict[str, float] = done.figures
    return document


@pytest.mark.slow
def test_hidden_elasticity_is_a_resonance(daq: Runner, ident: Runner, tmp_path: Path) -> None:
    compliance = 2e-5  # 124 Hz, of 200 Hz
    document = measure(daq, ident, tmp_path, ("joint_elasticity", "compliance", compliance))
    assert document["resonance_hz"] == pytest.approx(resonance(compliance), rel=0.03)
    assert document["delay"] == pytest.approx(0, abs=2e-4)
    assert (tmp_path / "bode.html").stat().st_size > 10_000
    assert (tmp_path / "response.csv").read_text().startswith("frequency,loop_magnitude")


@pytest.mark.slow
def test_hidden_delay_is_no_resonance(daq: Runner, ident: Runner, tmp_path: Path) -> None:
    delay = 0.003
    document = measure(daq, ident, tmp_path, ("actuation_delay", "delay", delay))
    assert document["resonance_hz"] is None
    assert document["delay"] == pytest.approx(delay, abs=2e-4)
