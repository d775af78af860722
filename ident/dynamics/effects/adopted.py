"""Effects that the user adopted: files in a folder from which every command reads, beside the library."""

import os
import shutil
from pathlib import Path

from recordings.errors import BadInput

FOLDER = "DELTA_WORKBENCH_EFFECTS"
"""Environment variable with the folder; empty: no effects are adopted."""


def folder() -> Path | None:
    """The folder of the adopted effects, which may not exist yet; None if there is none."""
    named = os.environ.get(FOLDER)
    if named is not None:
        return Path(named).expanduser() if named else None
    from platformdirs import user_data_path

    return user_data_path("delta-workbench") / "effects"


def files() -> list[Path]:
    """The files of the adopted effects."""
    place = folder()
    return sorted(place.glob("*.py")) if place else []


def adopt(path: Path, force: bool = False) -> Path:
    """Copy the effect file `path`, which was checked, to the folder; return the copy.

    Raises:
        BadInput: there is no folder, or it has an effect of this name and not `force`.
    """
    place = folder()
    if place is None:
        raise BadInput(
            f"{FOLDER}: a folder for adopted effects expected, none found; name one, or unset the variable"
        )
    copy = place / path.name
    if copy.exists() and not force:
        raise BadInput(
            f"effect {path.stem}: a name of its own expected, one in {place} found; add --force to replace it"
        )
    place.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(path, copy)
    return copy


def drop(name: str) -> Path:
    """Remove the adopted effect `name`; return the file that it was.

    Raises:
        BadInput: there is no such effect.
    """
    for path in files():
        if path.stem == name:
            path.unlink()
            return path
    known = ", ".join(path.stem for path in files()) or "none"
    raise BadInput(f"effect: an adopted one expected ({known}), {name!r} found; see ident effects")
