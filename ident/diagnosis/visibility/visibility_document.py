"""What recordings can show, as `ident check` prints it."""

from typing import Literal

from ident.data.recording_facts import JointFacts, RecordingFacts
from ident.diagnosis.visibility.visibility import SmallestSize
from recordings.config import ConfigSection, JsonDocument
from recordings.data_problems import DataProblem


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
