"""Short recordings with a known cause, and what a diagnosis must say of them: each guards an idea of search or judge.

A fast stand-in for the benchmark: whoever changes search or judge learns here, within a minute, what it costs.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose
from ident.diagnosis.document import verdict
from ident.diagnosis.document.document import Document
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.recording import Floats, Recording
from tests.ident import building
from tests.ident.conftest import write_recording

NOISE = 0.05
"""Standard deviation of the torque's noise [N m]; the RMS of the torque is 3 to 4 N m."""
CYCLES = 2
"""Of four seconds."""
Torque = Callable[[Motion], Floats]
"""(n, joints) torque of a motion [N m]."""
Change = Callable[[Recording], Recording]
"""What happens to a recording after the motion: a delay, spikes, a limit."""


@dataclass(frozen=True)
class Case:
    """Recordings of independent axes, and what a diagnosis must say of them."""

    guards: str
    """The idea of search or judge that this case needs."""
    torque: Torque | None = None
    """Hidden from the mechanism."""
    named: tuple[str, ...] = ()
    """The effects that are found, sorted; none may be confusable with another."""
    verdict: str = ""
    """Empty: `missing-effect` where effects are named, else `adequate`."""
    joints: tuple[int, ...] = (1,)
    """From 1, on which the effects that are named act."""
    likely: tuple[str, ...] = ()
    refused: Mapping[str, str] = field(default_factory=dict)
    """By the name of a rejected effect: the rule that decided."""
    problems: tuple[str, ...] = ()
    """Kinds of data problems."""
    dof: int = 1
    noise: float = NOISE
    held_out: bool = True
    """Whether there is another recording; else phase segments are held out."""
    motion: Mapping[str, Any] = field(default_factory=dict)
    """Options of `building.record`."""
    farther: float = 1.0
    """How much farther the motion that is held out goes."""
    change: Change = lambda recording: recording
    only: tuple[str, ...] = ()
    """Effects that the user asks for; the others are not tried."""

    @property
    def expected(self) -> str:
        """The verdict."""
        return self.verdict or ("missing-effect" if self.named else "adequate")


def document_of(case: Case, folder: Path) -> Document:
    """Record and diagnose `case` in the empty `folder`."""
    files = [_written(case, folder / f"{number}.mcap", number) for number in range(1 + case.held_out)]
    options = DiagnosisOptions(only=case.only)
    return verdict.to_document(diagnose(files[:1], files[1:], library(), options))


def _written(case: Case, path: Path, number: int) -> Path:
    options = {"cycles": CYCLES, "shape": number, "size": case.farther if number else 1.0, **case.motion}
    recording = building.record(case.dof, noise=case.noise, seed=number + 1, extra=case.torque, **options)
    return write_recording(replace(case.change(recording), path=path))


def delayed(seconds: float) -> Change:
    """Return what delays the effect of the torque: the drive gives it `seconds` before the motion needs it."""

    def change(recording: Recording) -> Recording:
        assert recording.effort is not None
        columns = [np.interp(recording.time + seconds, recording.time, column) for column in recording.effort.T]
        return replace(recording, effort=np.stack(columns, axis=1))

    return change


def with_spikes(count: int, size: float) -> Change:
    """Return what replaces `count` samples of the torque by `size` [N m]."""

    def change(recording: Recording) -> Recording:
        assert recording.effort is not None
        effort = recording.effort.copy()
        rows = np.random.default_rng(5).choice(len(effort), count, replace=False)
        effort[rows, 0] = size * np.where(np.arange(count) % 2, 1.0, -1.0)
        return replace(recording, effort=effort)

    return change


def unrepeated(recording: Recording) -> Recording:
    """The `recording` as one of a motion that does not repeat."""
    run = recording.run.model_copy(update={"cycles": 1, "period": float(recording.time[-1])})
    return replace(recording, run=run, repeat=np.zeros_like(recording.repeat))


def on_joint(number: int, torque: Torque) -> Torque:
    """`torque` (n, joints) on joint `number` (from 1) alone."""
    return lambda motion: torque(motion) * (np.arange(motion.position.shape[1]) == number - 1)


def spring(motion: Motion) -> Floats:
    """(n, joints) torque [N m]."""
    return 0.5 * (motion.position - 0.2)


def cable(motion: Motion) -> Floats:
    """(n, joints) torque [N m], steep at the end of the travel."""
    return 0.1 * np.exp(5.0 * (motion.position - 1.2))


def steeper_cable(motion: Motion) -> Floats:
    """(n, joints) torque [N m], of which a curve with nine knots leaves a little."""
    return 0.2 * np.exp(4.0 * (motion.position - 1.0))


def stribeck(motion: Motion) -> Floats:
    """(n, joints) torque [N m]."""
    return 0.6 * np.exp(-((motion.velocity / 0.3) ** 2)) * motion.direction


def quadratic(motion: Motion) -> Floats:
    """(n, joints) torque [N m]."""
    return 0.15 * motion.velocity * np.abs(motion.velocity)


def power_law(motion: Motion) -> Floats:
    """(n, joints) torque [N m], in place of most of the viscous friction."""
    return np.abs(motion.velocity) ** 0.4 * motion.direction - 0.6 * motion.velocity


def friction_over_angle(motion: Motion) -> Floats:
    """(n, joints) torque [N m]."""
    return 0.5 * np.sin(2.2 * motion.position + 0.5) * motion.direction


def wave(order: float, size: float = 0.5) -> Torque:
    """Return a torque of `size` [N m] that repeats `order` times per turn."""
    return lambda motion: size * np.sin(order * motion.position)


def vibration(motion: Motion) -> Floats:
    """(n, joints) torque [N m] that no effect explains."""
    time = np.arange(len(motion.position)) / building.RATE
    return np.broadcast_to(0.3 * np.sin(2 * np.pi * 17.25 * time)[:, None], motion.position.shape)


CASES = {
    "weak offset": Case(
        "what held-out rows do not confirm is not named",
        lambda motion: np.full_like(motion.position, 0.03),
        noise=0.2,
        verdict="undetermined",
        refused={"torque_offset": "held-out"},
    ),
    "negligible beside a vibration": Case(
        "negligible beside what else is missing is not named",
        lambda motion: 0.08 * motion.position + vibration(motion),
        verdict="unknown-structure",
        refused={"joint_spring": "size", "axis_weight": "size"},
    ),
    "weak Stribeck": Case(
        "what just exceeds the price of its parameters is named",
        lambda motion: 0.2 * stribeck(motion),
        ("stribeck",),
    ),
    "weaker Stribeck": Case(
        "what is too small beside the torque is no effect",
        lambda motion: 0.12 * stribeck(motion),
        refused={"stribeck": "training"},
    ),
    "Stribeck, asymmetry and spring": Case(
        "three effects",
        lambda m: 0.4 / 0.6 * stribeck(m) + 0.2 * np.abs(m.velocity) + spring(m),
        ("asymmetric_viscous", "joint_spring", "stribeck"),
    ),
    "offset and weight": Case(
        "an effect that the found one contains takes its place beside another",
        lambda motion: 0.3 + 0.15 * np.sin(motion.position + 0.7),
        ("axis_weight", "torque_offset"),
    ),
    "offset and Stribeck": Case(
        "the same, where the shape of the other is searched",
        lambda motion: 0.3 + stribeck(motion),
        ("stribeck", "torque_offset"),
    ),
    "one turn after another": Case(
        "a weight turns with the joint", wave(1), ("axis_weight",), motion={"drift": 2 * np.pi}
    ),
    "nothing": Case("nothing is found where nothing is missing"),
    "wave": Case("lines of any order are found", wave(9), ("cogging",)),
    "Stribeck": Case("the shape of an effect is searched", stribeck, ("stribeck",)),
    "power law": Case("an effect replaces one of the mechanism", power_law, ("power_law_friction",)),
    "load": Case(
        "friction under inertial load is no inertia",
        lambda motion: 0.06 * np.abs(motion.acceleration) * motion.direction,
        ("load_dependent_friction",),
    ),
    "asymmetry": Case(
        "asymmetry of friction is no constant", lambda motion: 0.3 * np.abs(motion.velocity), ("asymmetric_viscous",)
    ),
    "weight": Case(
        "a wave of one turn is a weight", lambda motion: 0.8 * np.sin(motion.position + 0.7), ("axis_weight",)
    ),
    "delay": Case("an effect that shifts all others is found", change=delayed(0.004), named=("actuation_delay",)),
    "spring and wave": Case(
        "a line beside a curve is not taken for a part of it",
        lambda motion: spring(motion) + wave(12, 0.3)(motion),
        ("cogging", "joint_spring"),
    ),
    "spring and friction over the angle": Case(
        "two curves over the same angle",
        lambda motion: spring(motion) + friction_over_angle(motion),
        ("joint_spring", "position_dependent_friction"),
    ),
    "Stribeck and quadratic": Case(
        "two kinds of friction are told from each other",
        lambda motion: stribeck(motion) + quadratic(motion),
        ("quadratic_friction", "stribeck"),
    ),
    "spring without weight": Case(
        "two effects that nearly cancel",
        lambda motion: 3.0 * (motion.position - np.sin(motion.position)),
        ("axis_weight", "joint_spring"),
    ),
    "cable that ends in the training motion": Case(
        "what lies beyond the travel of a curve says nothing against it",
        cable,
        ("position_torque",),
        farther=1.08,
    ),
    "cable that ends a little before": Case(
        "a curve over what a named curve is over does not refute it",
        steeper_cable,
        ("position_torque",),
        verdict="unknown-structure",
        farther=1.06,
    ),
    "spikes": Case(
        "outliers are reported, not fitted",
        spring,
        ("joint_spring",),
        change=with_spikes(6, 1e3),
        problems=("spikes",),
    ),
    "one direction": Case("what cannot be seen is not claimed", motion={"drift": 6.0}),
    "no repetition": Case("a noise floor from the spectrum", change=unrepeated),
    "spring without repetition": Case("the same, with a cause", spring, ("joint_spring",), change=unrepeated),
    "phases": Case("phase segments of one recording are held out", held_out=False),
    "spring in phases": Case("the same, with a cause", spring, ("joint_spring",), held_out=False),
    "much noise": Case("noise that would hide an effect allows no all-clear", noise=0.8, verdict="undetermined"),
    "two of three joints": Case(
        "only the joints that need an effect get it",
        lambda motion: spring(motion) * np.array([1.0, 0.0, 0.8]),
        ("joint_spring",),
        joints=(1, 3),
        dof=3,
    ),
    "second joint": Case(
        "the same, where the shape is searched", on_joint(2, stribeck), ("stribeck",), joints=(2,), dof=2
    ),
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_short_recording(case: Case, tmp_path: Path) -> None:
    document = document_of(case, tmp_path)
    found = sorted((finding.effect, *finding.confusable_with) for finding in document.findings)
    assert (document.verdict, found) == (case.expected, [(name,) for name in case.named]), case.guards
    added = [step.added for step in document.steps if step.added]
    assert [finding.effect for finding in document.findings] == list(dict.fromkeys(added)), (
        "in the order of the steps"
    )
    assert {finding.joints for finding in document.findings} <= {case.joints}, case.guards
    assert [finding.effect for finding in document.likely] == list(case.likely), case.guards
    assert tuple({problem.kind for problem in document.data_problems}) == case.problems, case.guards
    rules = {entry.effect: entry.evidence.decided_by for entry in document.rejected if entry.evidence}
    assert case.refused.items() <= rules.items(), case.guards
