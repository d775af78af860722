"""Why recordings do not show an effect, in plain words, and what to record to change that."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ident.data.recording_facts import JointFacts, RecordingFacts
from ident.diagnosis.visibility.visibility import EffectVisibility, JointVisibility
from ident.dynamics.effects.base import Additive, Effect, Signal
from ident.dynamics.effects.library import names as built_in
from recordings.next_command import NEXT_MOTION, free_name
from recordings.recording import Recording
from trajectories import names as trajectory_names

ONE_SPEED = 0.05
"""A joint has one speed if the speeds at which it moves vary by less than this share."""
ONE_DIRECTION = 0.01
"""A joint has one direction if it moves in the other one for less than this share of the time."""
CONSTANT_LOAD = 0.1
"""The load hardly changes if the torque varies by less than this share of its RMS."""
SMALL_TRAVEL = 0.2
"""A joint with less travel shows little of what depends on its angle [rad]."""
MOSTLY_REPRODUCED = 0.3
"""The rest of the model reproduces most of a torque if a smaller part of it is left (RMS)."""
_MORE_CYCLES = 10
"""Factor by which a longer recording exceeds the present one."""


@dataclass(frozen=True)
class Advice:
    """A reason, and what to record."""

    why: str
    record: str | None = None
    command: str | None = None


class Adviser:
    """Advice for the recordings that were checked."""

    def __init__(
        self, facts: RecordingFacts, recordings: Sequence[Recording], library: Mapping[str, Effect], share: float
    ) -> None:
        self._facts, self._library, self._share = facts, library, share
        self._files = [str(path) for path in dict.fromkeys(recording.path for recording in recordings)]
        self._run = recordings[0].run

    def visible(self, visibility: EffectVisibility) -> Advice:
        """Advice for an effect that shows, alone or as one of several."""
        best = visibility.best
        seen = f"It shows from {_percent(best.share)} of the torque on ({_size(best)})"
        if not visibility.imitations:
            return Advice(f"{seen}.")
        others = ", ".join(visibility.imitations)
        why = f"{seen}, but {others} would explain as much of {_percent(self._share)}."
        timeless = [name for name in visibility.imitations if self._can_design(name)]
        if not timeless or not self._can_design(visibility.name):
            return Advice(why, "Rule the others out at the machine: a motion does not tell them apart.")
        pairs = " ".join(f"--discriminate {visibility.name} {name}" for name in timeless)
        return Advice(
            why, f"Record a motion that tells it from {', '.join(timeless)}.", f"ident design {pairs} {self._design}"
        )

    def invisible(self, visibility: EffectVisibility) -> Advice:
        """Advice for an effect that this motion, or the noise, hides."""
        best = visibility.best
        joint = self._facts.joints[best.joint or 0]
        cause = _cause(visibility.effect, joint, self._facts)
        reasons = [cause[0]] if cause else []
        if best.share == float("inf"):
            reasons.append("Other parameters of the model reproduce its torque on this motion.")
        elif not best.possible:
            reasons.append(f"It would have to be larger than hardware has it ({_size(best)}).")
        else:
            hidden = f"it would have to be {_percent(best.share)} of the torque ({_size(best)})"
            if best.share > 1:
                hidden = "it would have to exceed the whole torque"
            reason = (
                f"other parameters of the model reproduce all but {_percent(best.outside)} of it"
                if best.outside < MOSTLY_REPRODUCED
                else "less is hidden in the noise"
            )
            reasons.append(f"To be seen, {hidden}: {reason}.")
        record = cause[1] if cause else "Record a motion that shows it better."
        return Advice(" ".join(reasons), record, self._command(visibility))

    def impossible(self, effect: Effect, reason: str, torque_measured: bool) -> Advice:
        """Advice for an effect that recordings of this rig cannot show, for a `reason`."""
        if "temperature" in effect.needs:
            return Advice(
                reason, "Record the temperatures of the drives (temperature_1 ...) while the machine warms up."
            )
        if isinstance(effect, Signal) and effect.report and torque_measured:
            return Advice(reason, "Record the voltage that the amplifiers are given (voltage_1 ...), not the torque.")
        if isinstance(effect, Signal) and effect.report:
            return Advice(reason, "Record the command to the amplifiers, and say so in the rig file.")
        return Advice(reason)

    def untested(self, effect: Effect, reason: str) -> Advice:
        """Advice for an effect that lacks something in these recordings, for a `reason`."""
        if "both directions" in effect.needs:
            return Advice(reason, "Record a motion with both directions.", f"ident design {self._design}")
        return Advice(reason)

    def _command(self, visibility: EffectVisibility) -> str | None:
        """The command for the next recording."""
        if visibility.effect.axis == "time":
            if self._run.trajectory not in trajectory_names():
                return None
            cycles = _MORE_CYCLES * max(self._run.cycles, 1)
            return f"daq record --traj {self._run.trajectory} --cycles {cycles}"
        if isinstance(visibility.effect, Additive) and self._can_design(visibility.name):
            return f"ident design --with {visibility.name} {self._design}"
        return f"ident design {self._design}"

    def _can_design(self, name: str) -> bool:
        """Whether `ident design` knows the effect, and a motion can show it."""
        return name in built_in() and self._library[name].axis != "time"

    @property
    def _design(self) -> str:
        """Options of `ident design` for the rig of the recordings."""
        recording = " ".join(f"--recording {shlex.quote(file)}" for file in self._files)
        return f"{recording} -o {free_name(NEXT_MOTION)}"


def _cause(effect: Effect, joint: JointFacts, facts: RecordingFacts) -> tuple[str, str] | None:
    """What the motion of a joint lacks to show the effect, and what to record; None if nothing obvious."""
    axis = effect.axis
    if axis == "time":
        return f"The recording lasts {facts.duration:.3g} s only.", "Record for longer, from a cold start."
    if axis == "velocity" and joint.rarer_direction < ONE_DIRECTION:
        return "No reversal: the joint moves in one direction only.", "Record a motion with both directions."
    if axis == "velocity" and joint.speed_spread < ONE_SPEED:
        return "One speed only.", "Record several speeds, slow ones as well."
    if axis == "load" and joint.torque_spread < CONSTANT_LOAD:
        return "The load hardly changes.", "Record a motion with other accelerations, or with a payload."
    if axis in ("position", "motor angle") and joint.position_unit == "rad" and joint.travel < SMALL_TRAVEL:
        travel = f"{joint.travel:.2g} {joint.position_unit}"
        return f"The joint moves over {travel} only.", "Record a motion over more of the joint's range."
    return None


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"


def _size(joint: JointVisibility) -> str:
    where = "" if joint.joint is None else f", joint {joint.joint + 1}"
    return f"{joint.parameter} = {joint.size:.2g} {joint.unit}{where}"
