"""Manifest of a data set of a real machine."""

import tomllib
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from recordings.config import ConfigSection, validated

FOLDER = Path(__file__).parent / "data_sets"


class Column(ConfigSection):
    """A column of the file, and the factor to SI units."""

    name: str
    factor: float = 1.0


class Part(ConfigSection):
    """A file of the data set."""

    path: str
    """Inside of the folder of all data sets."""
    use: Literal["train", "validate", "both", "begin"]
    """both: of every second, the first three quarters train and the last one validates; begin: the first 60 % train,
    the rest validates."""


class Claim(ConfigSection):
    """What is known about the machine."""

    effect: str = ""
    present: bool = True
    verdict: str = ""
    """In place of an effect: what the verdict has to be."""
    order: float | None = None
    """Periods per turn of a ripple."""
    tolerance: float = 0.01
    """Relative difference at which an order is right."""
    known_from: str
    """Who found it, and how."""


class Manifest(ConfigSection):
    """A data set."""

    name: str
    source: str
    get: str
    """How to get it."""
    licence: str
    joint_types: tuple[Literal["revolute", "prismatic"], ...] = ("revolute",)
    """Of single axes."""
    urdf: str = ""
    """Of an arm, inside of the folder of all data sets."""
    joints: tuple[str, ...] = ()
    """Names in the URDF."""
    parts: tuple[Part, ...]
    columns: dict[str, Column]
    """By their names in the import format."""
    torque: dict[str, Any] | None = None
    """Keys of the section [torque] of a rig file, such as the map of a voltage."""
    gravity: bool = False
    """Whether gravity loads the joint of a single axis."""
    claims: tuple[Claim, ...] = ()
    published: str = Field(default="", description="Held-out error of a published model, with its source.")


def manifests() -> list[Manifest]:
    """All manifests, by name.

    Raises:
        BadInput: a manifest is not valid.
    """
    return [load(path) for path in sorted(FOLDER.glob("*.toml"))]


def load(path: Path) -> Manifest:
    """Read one manifest.

    Raises:
        BadInput: it is not valid.
    """
    return validated(tomllib.loads(path.read_text(encoding="utf-8")), Manifest, str(path))
