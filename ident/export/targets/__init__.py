"""Exports of a model. One target is one module of this folder, named as the user types it.

It holds `write(request) -> Carried`, and `carried_file(out) -> Path`, the name of the document about the losses.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, Protocol, cast

from ident.basics import plugins
from ident.export.losses import Carried
from ident.export.paths import TorquePath
from ident.identification.model import Model


@dataclass(frozen=True, eq=False)
class ExportRequest:
    """What to export, and where to."""

    model: Model
    path: TorquePath
    """Motion of test vectors, of feed-forward tables, and of the losses."""
    out: Path
    precision: Literal["double", "float"] = "double"


class Target(Protocol):
    """Interface of each module of this folder."""

    def write(self, request: ExportRequest) -> Carried:
        """Write the export.

        Raises:
            BadInput: the model does not suit the target.
        """
        ...

    def carried_file(self, out: Path) -> Path:
        """Return the name of the document about the effects that are carried."""
        ...


def load(name: str) -> Target:
    """Load the target `name`.

    Raises:
        BadInput: there is no such target.
    """
    return cast(Target, plugins.load(__name__, name))


def beside(out: Path) -> Path:
    """Name of the document beside the file `out`: robot.xml, robot.carried.json."""
    return out.with_suffix(".carried.json")
