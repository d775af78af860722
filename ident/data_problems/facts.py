"""What the kinds of data problems look at, and what they say."""

from collections.abc import Sequence
from dataclasses import dataclass

from recordings.config import ConfigSection
from recordings.recording import Floats, Recording


@dataclass(frozen=True, eq=False)
class Facts:
    """Recordings as they were read, and what a fit says of their noise."""

    recordings: Sequence[Recording]
    torque_rms: Floats
    """(dof,) of the torque within the analysis band [N m]."""
    noise_rms: Floats
    """(dof,) noise floor of the model [N m]."""


class DataProblem(ConfigSection):
    """One problem, as all documents list it."""

    kind: str
    joints: tuple[int, ...]
    """From 1; empty for all."""
    blocks: bool
    """Whether the program cannot take it out itself."""
    why: str
    remedy: str
    """A command, or a sentence that says what to record."""
