"""Why recordings do not show an effect, in plain words, and what to record to change that."""

import shlex
from collections.abc import Mapping, Sequence

from ident.data.recording_facts import RecordingFacts
from ident.data.samples import holds_torque
from ident.diagnosis.visibility.visibility import Visibility
from ident.dynamics.effects.base import Additive, Effect, Need, Signal, SignatureAxis
from ident.dynamics.effects.library import names as built_in
from recordings.command_line import repeated
from recordings.config import ConfigSection
from recordings.next_command import NEXT_MOTION, free_name
from recordings.recording import Recording
from trajectories import names as trajectory_names

LITTLE = 0.1
"""Speed, torque or direction of a joint hardly vary below this share, nor its position below this travel [rad]."""
_MORE_CYCLES = 10
"""Factor by which a longer recording exceeds the present one."""
_TRAVEL = ("travel", "The joint hardly moves.", "Record a motion over more of the joint's range.")
_LACKS: Mapping[SignatureAxis, Sequence[tuple[str, str, str]]] = {
    "velocity": [
        ("rarer_direction", "Hardly a reversal.", "Record a motion with both directions."),
        ("speed_spread", "Hardly more than one speed.", "Record several speeds, slow ones as well."),
    ],
    "load": [
        ("torque_spread", "The load hardly changes.", "Record a motion with other accelerations, or with a payload.")
    ],
    "position": [_TRAVEL],
    "motor angle": [_TRAVEL],
}
"""What a motion may lack that shows an effect over this axis: name in `JointFacts`, reason, what to record."""
_NEEDED: Mapping[Need, str] = {
    "temperature": "Record the temperatures of the drives (temperature_1 ...) while the machine warms up.",
    "both directions": "Record a motion with both directions.",
}
_AMPLIFIER: Mapping[bool, str] = {
    True: "Record the voltage that the amplifiers are given (voltage_1 ...), not the torque.",
    False: "Record the command to the amplifiers, and say so in the rig file.",
}
"""What shows the amplifiers, by whether the torque was recorded."""


class Advice(ConfigSection):
    """A reason, and what to record."""

    why: str
    record: str | None = None
    command: str | None = None


class Adviser:
    """Advice for the recordings that were checked."""

    def __init__(
        self, facts: RecordingFacts, recordings: Sequence[Recording], library: Mapping[str, Effect], share: float
    ) -> None:
        self._facts, self._recordings, self._library, self._share = facts, recordings, library, share

    def advice(self, visibility: Visibility) -> Advice:
        """Advice for an effect that recordings of this kind can show."""
        return self._visible(visibility) if visibility.joints else self._invisible(visibility)

    def _visible(self, visibility: Visibility) -> Advice:
        """Advice for an effect that shows, alone or as one of several."""
        seen, others = f"It shows from {self._smallest(visibility)} on", visibility.confusable_with
        if not others:
            return Advice(why=f"{seen}.")
        why = f"{seen}, but {', '.join(others)} would explain as much of {_percent(self._share)}."
        told = [name for name in others if self._can_design(name) and self._can_design(visibility.effect)]
        if not told:
            return Advice(why=why, record="Rule the others out at the machine: a motion does not tell them apart.")
        pairs = [word for name in told for word in ("--discriminate", visibility.effect, name)]
        return Advice(
            why=why, record=f"Record a motion that tells it from {', '.join(told)}.", command=self._design(*pairs)
        )

    def _invisible(self, visibility: Visibility) -> Advice:
        """Advice for an effect that this motion, or the noise, hides."""
        hidden = (
            f"To be seen, it would have to be {self._smallest(visibility)}: other parameters of the model reproduce "
            f"all but {_percent(visibility.outside)} of it, and noise hides what is small."
        )
        effect, joint = self._library[visibility.effect], self._facts.joints[visibility.best_joint]
        if effect.axis == "time":
            return Advice(
                why=f"The recording lasts {self._facts.duration:.3g} s only. {hidden}",
                record="Record for longer, from a cold start.",
                command=self._longer(),
            )
        lacks = (lack for lack in _LACKS.get(effect.axis, ()) if getattr(joint, lack[0]) < LITTLE)
        _, why, record = next(lacks, ("", "", "Record a motion that shows it better."))
        excites = isinstance(effect, Additive) and self._can_design(visibility.effect)
        return Advice(
            why=f"{why} {hidden}".strip(),
            record=record,
            command=self._design("--with", visibility.effect) if excites else self._design(),
        )

    def not_recorded(self, name: str, why: str) -> Advice:
        """Advice for an effect that recordings of this kind do not show, whatever its size, for the reason `why`."""
        effect = self._library[name]
        records = [_NEEDED[need] for need in effect.needs]
        if isinstance(effect, Signal) and effect.report:
            records.append(_AMPLIFIER[holds_torque(self._recordings[0])])
        return Advice(
            why=why,
            record=" ".join(records) or None,
            command=self._design() if "both directions" in effect.needs else None,
        )

    def _longer(self) -> str | None:
        """The command that records more cycles of the same trajectory."""
        run = self._recordings[0].run
        command = f"daq record --traj {run.trajectory} --cycles {_MORE_CYCLES * max(run.cycles, 1)}"
        return command if run.trajectory in trajectory_names() else None

    def _smallest(self, visibility: Visibility) -> str:
        """The size from which an effect shows."""
        size = visibility.smallest
        where = "" if self._library[visibility.effect].whole_robot else f", joint {visibility.best_joint + 1}"
        if size is None:
            return "larger than hardware has it"
        return f"{_percent(size.share)} of the torque ({size.parameter} = {size.value:.2g} {size.unit}{where})"

    def _can_design(self, name: str) -> bool:
        """Whether `ident design` knows the effect, and a motion can show it."""
        return name in built_in() and self._library[name].axis != "time"

    def _design(self, *options: str) -> str:
        """The command that designs a motion for the rig of the recordings."""
        files = repeated("--recording", dict.fromkeys(recording.path for recording in self._recordings))
        return shlex.join(["ident", "design", *options, *files, "-o", str(free_name(NEXT_MOTION))])


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"
