"""Recordings computed from known parameters, without a simulator: motion of fig5a and fig5b, torque of Eq. (26)."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.sparse import hstack, identity

from ident.basics.filters import mean_sign
from ident.dynamics import mechanisms
from ident.dynamics.motion import Motion
from recordings.recording import Floats, Recording
from recordings.rig import Rig, simulated_rig
from recordings.writer import RecordingWriter
from tests.made_up import run_of
from trajectories import library

PAPER = np.array([4.3963, 5.3480, 0.3823, 0.3237, 0.3047, 3.2111, 1.1688, 3.1343, -9.1037, -7.6127, -9.2628])
"""Eq. (36), as printed."""
TRUTH = PAPER * np.repeat([1, -1], [5, 6])
"""Eq. (36) with friction positive where it opposes motion."""


def make_recording(
    trajectory: str = "fig5a",
    *,
    rig: Rig | None = None,
    rate: float = 500.0,
    cycles: int = 2,
    parameters: Floats = TRUTH,
    noise: float = 0.0,
    seed: int = 0,
    path: Path = Path("made.mcap"),
) -> Recording:
    """A recording whose torque is exactly Eq. (26) with `parameters`, plus white `noise` [V] on the voltage."""
    rig = rig or simulated_rig()
    reference = library.load(trajectory, rig, cycles, rate)
    direction = np.nan_to_num(mean_sign(reference.joint_velocity))  # at rest at both ends
    motion = Motion(reference.joint_position, reference.joint_velocity, reference.joint_acceleration, direction)
    torque = mechanisms.create(rig).regressor(motion) @ parameters
    n, dof = torque.shape
    voltage = np.sign(torque) * np.sqrt(np.abs(torque) / np.array(rig.torque.gain))
    voltage += np.random.default_rng(seed).normal(0.0, noise, voltage.shape)
    return Recording(
        path=path,
        rig=rig,
        run=run_of(
            trajectory=trajectory,
            trajectory_digest=reference.digest,
            period=reference.period,
            cycles=cycles,
            rate=rate,
            exit_status=0,
        ),
        time=np.arange(n) / rate,
        position=reference.joint_position.copy(),
        command=reference.joint_position.copy(),
        voltage=voltage,
        velocity=None,
        effort=None,
        statusword=np.zeros((n, dof), np.int64),
        error_code=np.zeros((n, dof), np.int64),
        repeat=reference.repeat,
        lateness=np.zeros(n),
        events=(),
    )


def write_recording(recording: Recording) -> Path:
    """Write `recording` to its path as MCAP, properly closed unless its run has no exit status."""
    with RecordingWriter(
        recording.path, recording.rig, recording.run.model_copy(update={"exit_status": None})
    ) as writer:
        for k, stamp in enumerate(np.rint(recording.time * 1e9).astype(np.int64).tolist()):
            effort = None if recording.effort is None else recording.effort[k]
            writer.joint_states(stamp, stamp, recording.position[k], None, effort)
            writer.joint_commands(stamp, stamp, recording.command[k])
            zeros = [0] * recording.rig.dof
            writer.amplifiers(stamp, stamp, k, recording.repeat[k], 0.0, recording.voltage[k], zeros, zeros)
    return recording.path


def least_absolute_deviations_by_simplex(regressor: Floats, torque: Floats, bounds: Floats) -> tuple[Floats, float]:
    """Minimum of (33) inside `bounds` as a linear program for HiGHS: residual = above - below, both >= 0."""
    m, k = regressor.shape
    cost = np.concatenate([np.zeros(k), np.ones(2 * m)])
    equations = hstack([regressor, identity(m), -identity(m)], format="csc")
    options = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    limits = [*bounds, *[(0, None)] * (2 * m)]
    solution = linprog(cost, A_eq=equations, b_eq=torque, bounds=limits, method="highs", options=options)
    return solution.x[:k], solution.fun


@pytest.fixture(scope="session")
def least_absolute_deviations() -> Callable[[Floats, Floats, Floats], tuple[Floats, float]]:
    return least_absolute_deviations_by_simplex


@pytest.fixture(scope="session")
def make() -> Callable[..., Recording]:
    return make_recording


@pytest.fixture(scope="session")
def write() -> Callable[[Recording], Path]:
    return write_recording


@pytest.fixture(scope="session")
def truth() -> Floats:
    return TRUTH


@pytest.fixture(scope="session")
def recording() -> Recording:
    """Two cycles of fig5a without noise."""
    return make_recording()
