"""Frequency responses of recordings that are made up from known ones."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.data.frequency_response import frequency_response
from recordings.errors import BadInput
from recordings.recording import Recording, Run
from recordings.rig import Rig, Torque, simulated_rig
from trajectories.multisine import multisine
from trajectories.trajectory import assemble

GAIN, LOOP, NOISE = 2.0, 0.5, 1e-5
RIG = simulated_rig().model_copy(update={"torque": Torque(map="linear", gain=(GAIN, GAIN, GAIN))})


def recording(rig: Rig = RIG, cycles: int = 3) -> Recording:
    """Joint 2 follows half of its command; its torque is the position times 3."""
    trajectory = assemble(multisine(rig, 2, 0.01), rig, cycles)
    rng = np.random.default_rng(1)
    n = len(trajectory.repeat)
    pose = trajectory.joint_position[0]
    position = pose + LOOP * (trajectory.joint_position - pose) + rng.normal(0, NOISE, (n, 3))
    words = np.zeros((n, 3), dtype=np.uint16)
    run = Run(
        trajectory=trajectory.name,
        trajectory_digest="",
        period=trajectory.period,
        cycles=cycles,
        rate=rig.rate,
        software="test",
        simulated=True,
        pace="lockstep",
        start="1970-01-01T00:00:00+00:00",
        exit_status=0,
    )
    return Recording(
        path=Path("made-up.mcap"),
        rig=rig,
        run=run,
        time=np.arange(n) / rig.rate,
        position=position,
        command=trajectory.joint_position,
        voltage=3 / GAIN * (position - pose),
        velocity=None,
        effort=None,
        statusword=words,
        error_code=words,
        repeat=trajectory.repeat,
        lateness=np.zeros(n),
        events=(),
    )


def test_known_responses_are_found_with_their_coherence() -> None:
    response = frequency_response(recording())
    assert response.joint == 2
    strong = response.loop_coherence > 0.99
    assert np.count_nonzero(strong) > 20
    assert response.loop[strong] == pytest.approx(LOOP, rel=0.2)
    assert np.median(np.abs(response.loop[strong])) == pytest.approx(LOOP, rel=0.01)
    assert response.motion == pytest.approx(1 / 3)
    assert response.loop_coherence[-1] < response.loop_coherence[0]


def test_the_motion_of_the_other_joints_is_kept() -> None:
    quiet = recording()
    carried = quiet.position + 0.1 * (quiet.position[:, 1:2] - quiet.position[0, 1]) * [1, 0, -2]
    run = quiet.run.model_copy(update={"torque_age": 2e-4})
    response = frequency_response(replace(quiet, position=carried, run=run))
    assert response.others.shape == (len(response.frequency), 2)
    assert np.median(response.others.real, axis=0) == pytest.approx([0.1, -0.2], rel=0.02)
    assert response.torque_age == 2e-4
    assert frequency_response(quiet).torque_age == 0


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda r: recording(cycles=1), "two whole repetitions"),
        (
            lambda r: replace(r, command=r.command + r.command[:, [1, 0, 2]]),
            "a motion of one joint expected, 2 joints move",
        ),
        (
            lambda r: replace(r, position=np.where(r.time[:, None] == 30.0, np.nan, r.position)),
            "the position has gaps",
        ),
        (
            lambda r: replace(r, position=np.where((r.time[:, None] == 30.0) & [1, 0, 0], np.nan, r.position)),
            "the joints that hold expected",
        ),
        (lambda r: replace(r, command=np.round(r.command, 2)), "lines with gaps between them"),
    ],
)
def test_other_recordings_are_refused(change: object, reason: str) -> None:
    assert callable(change)
    with pytest.raises(BadInput, match=reason):
        frequency_response(change(recording()))
