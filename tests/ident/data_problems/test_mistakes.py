"""Ordinary mistakes in recordings of a delta robot are told by kind and joint, and what is right is not."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from ident.basics import slicing
from ident.data.prepared_recording import PreparedRecording, prepare
from ident.data_problems import examined, kind_names
from ident.data_problems.implausible import ImplausibleData
from ident.dynamics.motion import Motion
from recordings.data_problems import DataProblem
from recordings.errors import BadInput
from recordings.reader import read
from recordings.recording import IMPORTED, Floats, Recording
from tests.ident import building
from tests.ident.conftest import TRUTH, make_recording

ENCODER_STEP = 4e-5


def robot(seed: int, motion: str = "fig5a") -> Recording:
    """A delta robot with measured torque, whose parameters are drawn."""
    random = np.random.default_rng(seed)
    recording = make_recording(motion, cycles=2, parameters=np.abs(TRUTH) * random.uniform(0.6, 1.5, len(TRUTH)))
    effort = np.sign(recording.voltage) * recording.voltage**2 * np.array(recording.rig.torque.gain)
    return replace(
        recording,
        position=np.round(recording.position / ENCODER_STEP) * ENCODER_STEP,
        effort=effort + random.normal(0.0, 0.1, effort.shape),
        voltage=np.full_like(effort, np.nan),
    )


def effort(change: Callable[[Floats], Floats]) -> Callable[[Recording], Recording]:
    """What happens to the effort (n, 3)."""

    def changed(recording: Recording) -> Recording:
        assert recording.effort is not None
        return replace(recording, effort=change(recording.effort.copy()))

    return changed


def position(change: Callable[[Floats], Floats]) -> Callable[[Recording], Recording]:
    """What happens to the position (n, 3)."""
    return lambda recording: replace(recording, position=change(recording.position.copy()))


def wrapped(q: Floats) -> Floats:
    """Let the encoder of joint 2 begin its turn within the motion."""
    zero = np.median(q[:, 1])
    return np.column_stack([q[:, 0], np.mod(q[:, 1] - zero, 2 * np.pi) + zero, q[:, 2]])


def short(recording: Recording) -> Recording:
    return cut(recording, slice(800, 800 + int(0.3 * recording.run.rate)))


def cut(recording: Recording, rows: slice) -> Recording:
    """These `rows` of a recording, with their times."""
    names = ("position", "command", "voltage", "effort", "statusword", "error_code", "repeat", "lateness")
    kept = {name: getattr(recording, name)[rows] for name in names}
    run = recording.run.model_copy(update={"rate": recording.run.rate / (rows.step or 1)})
    return replace(recording, run=run, time=recording.time[rows] - recording.time[rows][0], **kept)


def spiky(tau: Floats) -> Floats:
    tau[np.random.default_rng(1).choice(len(tau), 30), 0] = 1e4
    return tau


@dataclass(frozen=True)
class Mistake:
    """What happened to a recording, and what is to be said of it."""

    change: Callable[[Recording], Recording]
    kind: str
    joints: tuple[int, ...]
    remedy: str
    blocks: bool = True


MISTAKES = {
    "flipped torque": Mistake(
        effort(lambda tau: tau * [-1, 1, 1]), "torque-sign", (1,), "--map 'effort_1=effort_1:Nm*-1'"
    ),
    "swapped positions": Mistake(
        position(lambda q: q[:, [1, 0, 2]]), "joint-order", (1, 2), "--map position_1=position_2:rad"
    ),
    "swapped torques": Mistake(
        effort(lambda tau: tau[:, [1, 0, 2]]), "joint-order", (1, 2), "--map effort_1=effort_2:Nm"
    ),
    "angle within a turn": Mistake(position(wrapped), "angle-wrap", (2,), "--unwrap 2"),
    "degrees": Mistake(position(np.degrees), "angle-unit", (), "position_1=position_1:deg"),
    "motor angles": Mistake(position(lambda q: 5 * q), "gear-ratio", (), "position_1=position_1:rad/5"),
    "mN m": Mistake(effort(lambda tau: 1000 * tau), "torque-unit", (), "--map 'effort_1=effort_1:Nm*1e-3'"),
    "four cells of five empty": Mistake(
        effort(lambda tau: np.where(np.arange(len(tau))[:, None] % 5, np.nan, tau)),
        "missing-torque",
        (1, 2, 3),
        "Record the torque",
    ),
    "held": Mistake(effort(lambda tau: tau[np.arange(len(tau)) // 5 * 5]), "held-samples", (1, 2, 3), "--thin 5"),
    "constant": Mistake(effort(lambda tau: 0 * tau + 3.3), "missing-torque", (1, 2, 3), "Record the torque"),
    "white noise": Mistake(
        effort(lambda tau: np.random.default_rng(0).normal(0, 5, tau.shape)), "uninformative", (1, 2, 3), "Check how"
    ),
    "a third of a second": Mistake(short, "too-short", (), "Record some seconds"),
    "spikes": Mistake(effort(spiky), "spikes", (1,), "--drop-outliers", blocks=False),
}


def prepared(recordings: Sequence[Recording]) -> list[list[PreparedRecording]]:
    return [[prepare(recording, "parallel", None)] for recording in recordings]


def problems_of(*recordings: Recording) -> list[DataProblem]:
    """Everything that is found, in spite of which nothing is fitted or not."""
    try:
        return [problem for each in examined(recordings, prepared) for problem in each.problems]
    except ImplausibleData as error:
        return list(error.problems)


@pytest.mark.parametrize("motion", ["fig5a", "fig5b"])
@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_told_by_kind_and_joint_with_its_remedy(mistake: str, motion: str) -> None:
    expected = MISTAKES[mistake]
    recording = expected.change(robot(3, motion))
    (problem,) = problems_of(recording)
    assert (problem.kind, problem.joints, problem.blocks) == (expected.kind, expected.joints, expected.blocks)
    assert expected.remedy in problem.remedy
    assert problem.kind in kind_names()


def lighter(recording: Recording, share: float) -> Recording:
    """The recording with a `share` of its robot's weight taken out of the torque."""
    ((each,),) = prepared([recording])
    known = each.usable.all(axis=1)
    parameters = np.linalg.lstsq(np.concatenate(each.regressor[known]), each.torque[known].ravel(), rcond=None)[0]
    still = np.zeros_like(recording.position)
    weight = each.mechanism.gravity(Motion(recording.position, still, still, still), parameters)
    return effort(lambda tau: tau - share * weight)(recording)


@pytest.mark.parametrize("motion", ["fig5a", "fig5b"])
@pytest.mark.parametrize("seed", range(3))
def test_a_torque_without_weight_is_told_where_the_weight_is_known(seed: int, motion: str) -> None:
    (problem,) = problems_of(lighter(robot(seed, motion), 1.0))
    assert (problem.kind, problem.blocks) == ("gravity-missing", True)
    assert "Record the torque that the motor gives" in problem.remedy
    assert problems_of(lighter(robot(seed, motion), 0.4)) == [], "a lighter robot is none without weight"


@pytest.mark.parametrize("seed", range(3))
def test_nothing_is_said_of_what_is_right(seed: int) -> None:
    assert problems_of(robot(seed), robot(seed, "fig5b")) == []


@pytest.mark.parametrize(("rate", "enough"), [(500, 0.55), (250, 0.55), (100, 0.8), (50, 1.6), (25, 3.2)])
def test_slower_recordings_have_to_last_longer(rate: int, enough: float) -> None:
    step = 500 // rate
    shorter, long_enough = (
        cut(robot(3), slice(600, 600 + int(500 * seconds), step)) for seconds in (0.75 * enough, enough)
    )
    (problem,) = problems_of(shorter)
    assert problem.kind == "too-short"
    assert f"At {rate} Hz" in problem.why
    assert "too-short" not in {problem.kind for problem in problems_of(long_enough)}


def test_a_single_axis_without_weight_has_the_sign_of_its_inertia() -> None:
    recording = building.record(noise=0.05)
    assert recording.effort is not None
    flipped = replace(recording, effort=-recording.effort)
    (problem,) = problems_of(flipped)
    assert (problem.kind, problem.joints) == ("torque-sign", (1,))
    assert problems_of(recording) == []


def test_a_joint_that_moves_on_in_a_pause_is_not_within_one_turn() -> None:
    """An axis that turns fast, of which half a second is missing."""
    recording = building.record(noise=0.05, drift=4 * np.pi)
    kept = (recording.time < 3.0) | (recording.time > 3.5)
    assert [problem.kind for problem in problems_of(slicing.along_time(recording, kept))] == []
    (problem,) = problems_of(position(lambda q: np.mod(q, 2 * np.pi))(recording))
    assert problem.kind == "angle-wrap"


SAMPLE = Path(__file__).parents[3] / "recordings" / "samples" / "fig5a.mcap"


def test_exchanged_positions_are_told_where_the_wrong_order_explains_much() -> None:
    recording = read(SAMPLE)
    assert problems_of(recording) == []
    (problem,) = problems_of(position(lambda q: q[:, [1, 0, 2]])(recording))
    assert (problem.kind, problem.joints) == ("joint-order", (1, 2))
    assert "24% of the torque is left unexplained, exchanged 1%" in problem.why
    assert "correct the order of [[drives]]" in problem.why  # this program has recorded it
    foreign = replace(recording, run=recording.run.model_copy(update={"trajectory": IMPORTED}))
    (of_others,) = problems_of(position(lambda q: q[:, [1, 0, 2]])(foreign))
    assert "[[drives]]" not in of_others.why
    assert "Without commands" not in of_others.why
    without = replace(foreign, command=np.full_like(foreign.command, np.nan))
    (of_either,) = problems_of(position(lambda q: q[:, [1, 0, 2]])(without))
    assert "Without commands it may be the torques instead: then map those." in of_either.why


@pytest.mark.parametrize("commands", [True, False])
def test_velocities_in_place_of_positions_are_told(commands: bool) -> None:
    recording = robot(3)
    changed = replace(recording, position=np.gradient(recording.position, recording.time, axis=0))
    if not commands:
        changed = replace(changed, command=np.full_like(changed.command, np.nan))
    (problem,) = problems_of(changed)
    assert (problem.kind, problem.joints, problem.blocks) == ("derivative", (1, 2, 3), True)


def test_times_in_milliseconds_are_told() -> None:
    recording = robot(3)
    (problem,) = problems_of(replace(recording, time=recording.time * 1000))
    assert problem.kind == "time-unit"
    assert "--map time=time:ms" in problem.remedy


def test_seconds_that_are_called_milliseconds_are_told() -> None:
    recording = robot(3)
    (problem,) = problems_of(replace(recording, time=recording.time / 1000))
    assert problem.kind == "time-unit"
    assert "--map 'time=time:s*1000'" in problem.remedy


def test_torques_whose_squares_vanish_are_none() -> None:
    recording = effort(lambda tau: 1e-320 * np.rint(tau))(robot(3))
    (problem,) = problems_of(recording)
    assert (problem.kind, problem.joints) == ("missing-torque", (1, 2, 3))
    with pytest.raises(BadInput, match="an effort that drives the motion expected"):
        examined([recording], prepared, ["missing-torque"])


def test_accepted_problems_are_listed_and_do_not_block() -> None:
    recording = MISTAKES["flipped torque"].change(robot(3))
    ((problem,),) = (each.problems for each in examined([recording], prepared, ["torque-sign"]))
    assert (problem.kind, problem.blocks) == ("torque-sign", True)
    with pytest.raises(BadInput, match=r"a kind of data problem expected .*torque-sign.*, 'sign' found"):
        examined([recording], prepared, ["sign"])


@pytest.mark.parametrize(
    ("signal", "what", "remedy"), [("effort", "torques", "effort_1"), ("position", "positions", "position_1")]
)
def test_an_arm_tells_which_of_torques_and_positions_are_exchanged(signal: str, what: str, remedy: str) -> None:
    pytest.importorskip("pinocchio")
    from tests.ident import arms

    recording = arms.record(arms.urdf(arms.LIFTING))
    values = getattr(recording, signal)
    values[:] = values[:, ::-1].copy()
    (problem,) = problems_of(recording)
    assert problem.kind == "joint-order"
    assert problem.why.startswith(f"The {what} of joints 1, 2")
    assert problem.why.endswith("exchanged 0%.")
    assert f"--map {remedy}=" in problem.remedy
