"""What recordings can show, as `ident check` prints it."""

from collections.abc import Callable, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any, Literal, get_args

from pydantic import Field

from ident.data.prepared_recording import PreparedRecording
from ident.data.recording_facts import JointFacts, recording_facts
from ident.diagnosis.diagnosis import DiagnosisOptions, prepare_inputs
from ident.diagnosis.search.search import Search
from ident.diagnosis.visibility.visibility import SmallestSize as SmallestSize
from ident.diagnosis.visibility.visibility import Status, Visibility, VisibilityCheck
from ident.diagnosis.visibility.visibility_advice import Advice, Adviser
from ident.dynamics.effects.base import Effect
from recordings.config import ConfigSection


class CheckedRecording(ConfigSection):
    """One recording."""

    file: str
    simulated: bool
    rate_hz: float
    jitter: float
    """Standard deviation of the steps of time, relative to their median."""
    duration_s: float
    cycles: int


class CheckedJoint(ConfigSection):
    """Motion, torque and resolution of one joint, in all recordings together."""

    joint: str
    position_unit: str
    effort_unit: str
    travel: float
    highest_speed: float
    speed_spread: float
    forward_share: float
    encoder_step: float | None
    """None where the readings are continuous."""
    drive_step: float | None
    torque_rms: float
    noise_rms: float | None
    """Noise floor; None if nothing repeats."""


class CheckedEffect(Advice, Visibility):
    """What the recordings can show of one effect, why, and what to record to change that."""


class CheckDocument(ConfigSection):
    """The result of a check."""

    schema_version: Literal[2] = Field(2, alias="schema")
    share: float
    """Size for which the effects are judged: RMS of their torque, relative to that of the joint."""
    bandwidth_hz: float
    recordings: tuple[CheckedRecording, ...]
    joints: tuple[CheckedJoint, ...]
    effects: tuple[CheckedEffect, ...]

    def as_json(self) -> dict[str, Any]:
        """The document as it is printed."""
        return dict(self.model_dump(mode="json", by_alias=True))


def check(
    files: Sequence[Path],
    library: Mapping[str, Effect],
    share: float,
    progress: Callable[[str], None] = lambda text: None,
) -> CheckDocument:
    """Check what the recordings `files` can show of effects with a torque of this `share` of that of the joint.

    Raises:
        BadInput: a recording cannot be used, or the recordings are not of the same rig.
    """
    inputs = prepare_inputs(files, [], library, DiagnosisOptions())
    effects, prepared = inputs.effects, inputs.split.recordings
    progress("fitting the base model")
    model, _ = Search(inputs.split, effects.observable, progress).start(*inputs.initial_model(library))
    progress("looking at every effect")
    facts = recording_facts(prepared)
    adviser = Adviser(facts, [data.recording for data in prepared], library, share)
    shown = [
        CheckedEffect(**dict(visibility), **dict(adviser.advice(visibility)))
        for visibility in VisibilityCheck(model, effects.observable, share).effects()
    ]
    # Of a long recording, several excerpts are prepared.
    excerpts = groupby(prepared, key=lambda data: data.recording.path)
    return CheckDocument(
        schema=2,
        share=share,
        bandwidth_hz=prepared[0].bandwidth,
        recordings=tuple(_recording(path, list(each)) for path, each in excerpts),
        joints=tuple(map(_joint, facts.joints, model.noise_floor.rms.tolist())),
        effects=(
            *sorted(shown, key=lambda entry: get_args(Status).index(entry.status)),
            *(
                CheckedEffect(effect=name, status="not-visible", **dict(adviser.not_recorded(name, why)))
                for name, why in (*effects.untested.items(), *effects.unobservable.items())
            ),
        ),
    )


def _recording(path: Path, excerpts: Sequence[PreparedRecording]) -> CheckedRecording:
    facts = recording_facts(excerpts)
    return CheckedRecording(
        file=str(path),
        simulated=excerpts[0].recording.run.simulated,
        rate_hz=facts.rate,
        jitter=facts.jitter,
        duration_s=facts.duration,
        cycles=facts.cycles,
    )


def _joint(facts: JointFacts, noise_rms: float | None) -> CheckedJoint:
    return CheckedJoint(
        joint=facts.name,
        position_unit=facts.position_unit,
        effort_unit=facts.effort_unit,
        travel=facts.travel,
        highest_speed=facts.highest_speed,
        speed_spread=facts.speed_spread,
        forward_share=facts.forward_share,
        encoder_step=facts.encoder_step or None,
        drive_step=facts.drive_step or None,
        torque_rms=facts.torque_rms,
        noise_rms=noise_rms,
    )
