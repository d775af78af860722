"""Check what recordings can show: each effect with its size, or the reason why they do not show it and what would."""

from collections.abc import Callable, Mapping, Sequence
from typing import Literal

import numpy as np

from ident.data.recording_facts import JointFacts, RecordingFacts, recording_facts
from ident.data.samples import holds_torque
from ident.diagnosis.diagnosis import DiagnosisOptions, prepare_inputs
from ident.diagnosis.search.search import Search
from ident.diagnosis.visibility.visibility import EffectVisibility, JointVisibility, SmallestSize, VisibilityCheck
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.library import names as built_in
from recordings.config import ConfigSection, JsonDocument
from recordings.data_problems import DataProblem
from recordings.next_command import design
from recordings.notebook import html_table
from recordings.reader import Source
from recordings.recording import Recording
from trajectories import names as trajectory_names

ONE_DIRECTION = 0.01
"""A joint has one direction if it moves in the other one for less than this share of the time."""
HARDLY_CHANGES = 0.1
"""A speed, or a load, hardly changes if it varies by less than this share."""
SMALL_TRAVEL = 0.2
"""A joint with less travel shows little of what depends on its angle [rad]."""
MOSTLY_REPRODUCED = 0.3
"""The rest of the model reproduces most of a torque if a smaller part of it is left (RMS)."""


class CheckedJoint(JointFacts):
    """Motion, torque and resolution of one joint, in all recordings together."""

    noise_rms: float
    """Noise floor."""


class CheckedEffect(ConfigSection):
    """What the recordings can show of one effect."""

    effect: str
    status: Literal["visible", "confusable", "not-visible"] = "not-visible"
    joints: tuple[int, ...] = ()
    """Joints that show it, from 1; of the whole robot: all."""
    confusable_with: tuple[str, ...] = ()
    smallest: SmallestSize | None = None
    """On the joint that shows it best; None if this motion shows none."""
    why: str
    record: str | None = None
    command: str | None = None


class CheckDocument(JsonDocument):
    """The result of a check."""

    data_problems: tuple[DataProblem, ...] = ()
    share: float
    """Size for which the effects are judged: RMS of their torque, relative to that of the joint."""
    bandwidth_hz: float
    recordings: tuple[RecordingFacts, ...]
    """Files; a long one is analysed in excerpts."""
    joints: tuple[CheckedJoint, ...]
    effects: tuple[CheckedEffect, ...]
    """Those that show first."""

    def __repr__(self) -> str:
        """One line: how many effects show."""
        return (
            f"<CheckDocument: {sum(each.status == 'visible' for each in self.effects)} of {len(self.effects)} "
            f"effects visible where they take {_percent(self.share)} of the torque>"
        )

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """The effects as a table: whether each shows, and why, for a notebook."""
        rows = [
            (each.effect, each.status, f"{each.smallest.share:.2%}" if each.smallest else "", each.why)
            for each in self.effects
        ]
        return html_table(repr(self), ("effect", "status", "shows from", "why"), rows)


def check(
    files: Sequence[Source],
    library: Mapping[str, Effect],
    share: float,
    progress: Callable[[str], None] = lambda text: None,
    accept: tuple[str, ...] = (),
) -> CheckDocument:
    """Check what the recordings `files` can show of effects with a torque of this `share` of that of the joint.

    accept: kinds of data problems in spite of which they are used.

    Raises:
        ImplausibleData: a recording cannot be what it is said to be.
        BadInput: a recording cannot be used, or the recordings are not of the same rig.
    """
    inputs = prepare_inputs(files, [], library, DiagnosisOptions(accept=accept))
    prepared, effects = inputs.split.recordings, inputs.effects
    progress("fitting the base model")
    model, _ = Search(inputs.split, effects.observable, progress).start(*inputs.initial_model(library))
    progress("looking at every effect")
    facts = recording_facts(prepared)
    adviser = Adviser(facts, [data.recording for data in prepared], library, share)
    judged = map(adviser.judged, VisibilityCheck(model, effects.observable).effects(share))
    return CheckDocument(
        schema=2,
        data_problems=inputs.problems,
        share=share,
        bandwidth_hz=prepared[0].bandwidth,
        recordings=tuple(
            recording_facts([data for data in prepared if data.recording.path == path])
            for path in dict.fromkeys(data.recording.path for data in prepared)
        ),
        joints=tuple(
            CheckedJoint(**vars(joint), noise_rms=rms)
            for joint, rms in zip(facts.joints, model.noise_floor.rms.tolist(), strict=True)
        ),
        effects=(
            *sorted(judged, key=lambda entry: ("visible", "confusable", "not-visible").index(entry.status)),
            *(adviser.unjudged(name, why, untested=True) for name, why in effects.untested.items()),
            *(adviser.unjudged(name, why, untested=False) for name, why in effects.unobservable.items()),
        ),
    )


class Adviser:
    """Says of effects what the recordings that were checked show, and what to record if that is not enough."""

    def __init__(
        self, facts: RecordingFacts, recordings: Sequence[Recording], library: Mapping[str, Effect], share: float
    ) -> None:
        self._facts, self._library, self._share = facts, library, share
        self._files, self._recording = [recording.path for recording in recordings], recordings[0]
        self._set_ups = {(recording.rig.payload, recording.beyond) for recording in recordings}

    def judged(self, visibility: EffectVisibility) -> CheckedEffect:
        """The entry of an effect that was judged."""
        visible, best = visibility.visible_joints(self._share), visibility.best
        why, record, command = self._shown(visibility) if visible else self._hidden(visibility)
        return CheckedEffect(
            effect=visibility.name,
            status="not-visible" if not visible else "confusable" if visibility.imitations else "visible",
            joints=tuple(
                number
                for each in visible
                for number in (range(1, 1 + len(self._facts.joints)) if each.joint is None else (each.joint + 1,))
            ),
            confusable_with=visibility.imitations,
            smallest=best.smallest if np.isfinite(best.smallest.share) else None,
            why=why,
            record=record,
            command=command,
        )

    def _shown(self, visibility: EffectVisibility) -> tuple[str, str | None, str | None]:
        """Why, what to record, and the command, for an effect that shows, alone or as one of several."""
        name, imitations, best = visibility.name, visibility.imitations, visibility.best
        seen = f"It shows from {_percent(best.smallest.share)} of the torque on ({_size(best)})"
        if not imitations:
            return f"{seen}.", None, None
        why = f"{seen}, but {', '.join(imitations)} would explain as much of {_percent(self._share)}."
        timeless = [other for other in imitations if self._can_design(other)]
        if not timeless or not self._can_design(name):
            return why, "Rule the others out at the machine: a motion does not tell them apart.", None
        pairs = [word for other in timeless for word in ("--discriminate", name, other)]
        # What the load does, another load tells from all that it does not.
        others = [each for each in imitations if self._library[each].axis != self._library[name].axis]
        loaded = others and "load" in {self._library[each].axis for each in (name, *others)}
        payload = ", or this one with another payload (--payload)" if loaded and len(self._set_ups) == 1 else ""
        record = f"Record a motion that tells it from {', '.join(timeless)}{payload}."
        return why, record, design(self._files, *pairs)

    def _hidden(self, visibility: EffectVisibility) -> tuple[str, str, str | None]:
        """The same for an effect that this motion, or the noise, hides."""
        best, size, share = visibility.best, _size(visibility.best), visibility.best.smallest.share
        cause, record = self._cause(self._library[visibility.name], self._facts.joints[best.joint or 0])
        seen = f"be {_percent(share)} of the torque ({size})" if share <= 1 else "exceed the whole torque"
        reproduced = f"other parameters of the model reproduce all but {_percent(best.outside)} of it"
        reasons = (
            (not np.isfinite(share), "Other parameters of the model reproduce its torque on this motion."),
            (not best.possible, f"It would have to be larger than hardware has it ({size})."),
            (best.outside < MOSTLY_REPRODUCED, f"To be seen, it would have to {seen}: {reproduced}."),
            (True, f"To be seen, it would have to {seen}: less is hidden in the noise."),
        )
        return cause + next(reason for applies, reason in reasons if applies), record, self._command(visibility.name)

    def unjudged(self, name: str, reason: str, untested: bool) -> CheckedEffect:
        """The entry of an effect that recordings of this rig cannot show, for a `reason`.

        untested: they could show it, but these lack something.
        """
        effect = self._library[name]
        directions = untested and "both directions" in effect.needs
        records = (
            (directions, "Record a motion with both directions."),
            (
                "temperature" in effect.needs,
                "Record the temperatures of the drives (temperature_1 ...) while the machine warms up.",
            ),
            (
                effect.distorts_report and holds_torque(self._recording),
                "Record the voltage that the amplifiers are given (voltage_1 ...), not the torque.",
            ),
            (effect.distorts_report, "Record the command to the amplifiers, and say so in the rig file."),
        )
        return CheckedEffect(
            effect=name,
            why=reason,
            record=next((record for applies, record in records if applies), None),
            command=design(self._files) if directions else None,
        )

    def _cause(self, effect: Effect, joint: JointFacts) -> tuple[str, str]:
        """What the motion of a joint lacks to show the effect, if that is obvious, and what to record."""
        axis, moves_little = effect.axis, joint.position_unit == "rad" and joint.travel < SMALL_TRAVEL
        causes = [
            (
                axis == "time",
                f"The recording lasts {self._facts.duration_s:.3g} s only. ",
                "Record for longer, from a cold start.",
            ),
            (
                axis == "velocity" and joint.rarer_direction < ONE_DIRECTION,
                "No reversal: the joint moves in one direction only. ",
                "Record a motion with both directions.",
            ),
            (
                axis == "velocity" and joint.speed_spread < HARDLY_CHANGES,
                "One speed only. ",
                "Record several speeds, slow ones as well.",
            ),
            (
                axis == "load" and joint.torque_spread < HARDLY_CHANGES,
                "The load hardly changes. ",
                "Record a motion with other accelerations, or with a payload.",
            ),
            (
                axis in ("position", "motor angle") and moves_little,
                f"The joint moves over {joint.travel:.2g} rad only. ",
                "Record a motion over more of the joint's range.",
            ),
            (True, "", "Record a motion that shows it better."),
        ]
        return next((why, record) for applies, why, record in causes if applies)

    def _command(self, name: str) -> str | None:
        """The command that records the effect, or designs a motion that shows it; None if it is not known."""
        effect, run = self._library[name], self._recording.run
        if effect.axis != "time":
            additive = effect.linear and self._can_design(name)
            return design(self._files, *(("--with", name) if additive else ()))
        longer = f"daq record --traj {run.trajectory} --cycles {10 * max(run.cycles, 1)}"
        return longer if run.trajectory in trajectory_names() else None

    def _can_design(self, name: str) -> bool:
        """Whether `ident design` knows the effect, and a motion can show it."""
        return name in built_in() and self._library[name].axis != "time"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %"


def _size(joint: JointVisibility) -> str:
    where = "" if joint.joint is None else f", joint {joint.joint + 1}"
    return f"{joint.smallest.parameter} = {joint.smallest.value:.2g} {joint.smallest.unit}{where}"
