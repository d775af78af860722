"""What recordings can show, as `ident check` prints it."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from ident.data.recording_facts import JointFacts, recording_facts
from ident.data.samples import holds_torque
from ident.diagnosis.diagnosis import DiagnosisInputs, DiagnosisOptions, prepare_inputs
from ident.diagnosis.search.search import Search
from ident.diagnosis.visibility.visibility import EffectVisibility, VisibilityCheck
from ident.diagnosis.visibility.visibility_advice import Advice, Adviser
from ident.dynamics.effects.base import Effect
from recordings.config import ConfigSection

Status = Literal["visible", "confusable", "not-visible"]


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
    noise_rms: float
    """Noise floor."""


class SmallestSize(ConfigSection):
    """The size from which an effect shows."""

    share: float
    """RMS of its torque, relative to that of the joint."""
    parameter: str
    value: float
    unit: str


class CheckedEffect(ConfigSection):
    """What the recordings can show of one effect."""

    effect: str
    status: Status
    joints: tuple[int, ...]
    """Joints that show it, from 1; of the whole robot: all."""
    confusable_with: tuple[str, ...]
    smallest: SmallestSize | None
    """On the joint that shows it best; None if this motion shows none."""
    why: str
    record: str | None
    command: str | None


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
        document: dict[str, Any] = self.model_dump(mode="json", by_alias=True)
        return document


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
    split = inputs.split
    progress("fitting the base model")
    model, _ = Search(split, inputs.effects.observable, progress).start(*inputs.initial_model(library))
    progress("looking at every effect")
    visibilities = VisibilityCheck(split, model, inputs.effects.observable).effects(share)
    floor = model.noise_floor
    facts = recording_facts(split.recordings)
    adviser = Adviser(facts, [data.recording for data in split.recordings], library, share)
    return CheckDocument(
        schema=2,
        share=share,
        bandwidth_hz=split.recordings[0].bandwidth,
        recordings=_recordings(inputs),
        joints=tuple(map(_joint, facts.joints, tuple(floor.rms.tolist()))),
        effects=(
            *sorted(
                (_checked(adviser, visibility, share, len(facts.joints)) for visibility in visibilities), key=_rank
            ),
            *_hidden(adviser, inputs, library),
        ),
    )


def _recordings(inputs: DiagnosisInputs) -> tuple[CheckedRecording, ...]:
    """One entry per file; a long recording is prepared as several excerpts."""
    excerpts: dict[Path, list[Any]] = {}
    for data in inputs.split.recordings:
        excerpts.setdefault(data.recording.path, []).append(data)
    entries = []
    for path, prepared in excerpts.items():
        facts = recording_facts(prepared)
        entries.append(
            CheckedRecording(
                file=str(path),
                simulated=prepared[0].recording.run.simulated,
                rate_hz=facts.rate,
                jitter=facts.jitter,
                duration_s=facts.duration,
                cycles=facts.cycles,
            )
        )
    return tuple(entries)


def _joint(facts: JointFacts, noise_rms: float) -> CheckedJoint:
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


def _checked(adviser: Adviser, visibility: EffectVisibility, share: float, dof: int) -> CheckedEffect:
    visible, best = visibility.visible_joints(share), visibility.best
    status: Status = "not-visible" if not visible else "confusable" if visibility.imitations else "visible"
    advice = adviser.visible(visibility) if visible else adviser.invisible(visibility)
    joints = [range(dof) if joint.joint is None else (joint.joint,) for joint in visible]
    smallest = None
    if best.share < float("inf"):
        smallest = SmallestSize(share=best.share, parameter=best.parameter, value=best.size, unit=best.unit)
    return _entry(
        visibility.name,
        status,
        advice,
        tuple(number + 1 for numbers in joints for number in numbers),
        visibility.imitations,
        smallest,
    )


def _hidden(adviser: Adviser, inputs: DiagnosisInputs, library: Mapping[str, Effect]) -> list[CheckedEffect]:
    """Effects that the kind of recording does not show, whatever the motion; and those that lack something in it."""
    torque_measured = holds_torque(inputs.split.recordings[0].recording)
    unobservable, untested = inputs.effects.unobservable, inputs.effects.untested
    return [
        *(_entry(name, "not-visible", adviser.untested(library[name], why)) for name, why in untested.items()),
        *(
            _entry(name, "not-visible", adviser.impossible(library[name], why, torque_measured))
            for name, why in unobservable.items()
        ),
    ]


def _entry(
    name: str,
    status: Status,
    advice: Advice,
    joints: tuple[int, ...] = (),
    confusable_with: tuple[str, ...] = (),
    smallest: SmallestSize | None = None,
) -> CheckedEffect:
    return CheckedEffect(
        effect=name,
        status=status,
        joints=joints,
        confusable_with=confusable_with,
        smallest=smallest,
        why=advice.why,
        record=advice.record,
        command=advice.command,
    )


def _rank(entry: CheckedEffect) -> int:
    """Order: visible effects first."""
    return ("visible", "confusable", "not-visible").index(entry.status)
