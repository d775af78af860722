"""Exports of a model. One target is one module of this folder, named as the user types it.

It holds `write(request) -> Carried`, `carried_file(out) -> Path`, the name of the document about the losses, and, if
it has any, its `Settings`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol, cast

from ident.basics import plugins
from ident.estimation.settings import create
from ident.export.losses import Carried
from ident.export.paths import TorquePath
from ident.identification.model import Model
from recordings.errors import told


@dataclass(frozen=True, eq=False)
class ExportRequest:
    """What to export, and where to."""

    model: Model
    path: TorquePath
    """Motion of test vectors, of feed-forward tables, and of the losses."""
    out: Path
    settings: Any
    """`Settings` of the target."""
    digest: str
    """SHA-256 of the model file."""
    precision: Literal["double", "float"] = "double"


@dataclass(frozen=True)
class NoSettings:
    """Of a target that has none."""


class Target(Protocol):
    """Interface of each module of this folder."""

    def write(self, request: ExportRequest) -> Carried:
        """Write the export.

        Raises:
            BadInput: the model does not suit the target.
        """

    def carried_file(self, out: Path) -> Path:
        """Return the name of the document about the effects that are carried."""


def load(name: str) -> Target:
    """Load the target `name`.

    Raises:
        BadInput: there is no such target.
    """
    return cast(Target, plugins.load(__name__, name))


def settings(name: str, given: Mapping[str, Any]) -> Any:
    """Create the settings of the target `name` from `given` values.

    Raises:
        BadInput: there is no such target or setting, or a value is out of range.
    """
    advice = f"change {told('--set', 'settings')}"
    return create(getattr(load(name), "Settings", NoSettings), given, f"export to {name}", advice)


def beside(out: Path) -> Path:
    """Name of the document beside the file `out`: robot.xml, robot.xml.carried.json."""
    return out.with_name(f"{out.name}.carried.json")
