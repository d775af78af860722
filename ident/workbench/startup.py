"""From what was typed to a session."""

from collections.abc import Sequence
from pathlib import Path

from ident.workbench.folder import SUFFIX, Folder
from ident.workbench.session import Session
from recordings.errors import BadInput


def opened(places: Sequence[Path], effect_files: Sequence[Path] = ()) -> Session:
    """The session of one folder, or of the folder of one or two recordings, which are then chosen.

    Raises:
        BadInput: they are not there, or not in one folder.
    """
    if not places:
        return Session(Folder.at(Path()), effect_files)
    if len(places) == 1 and places[0].is_dir():
        return Session(Folder.at(places[0]), effect_files)
    for place in places:
        if not place.is_file() or place.suffix != SUFFIX:
            raise BadInput(f"a folder, or existing recordings ({SUFFIX}), expected, {place} found; check the path")
    folders = {place.absolute().parent.resolve() for place in places}
    if len(places) > 2 or len(folders) > 1:
        raise BadInput(
            f"one folder, or a recording to fit and one to validate on in the same folder, expected, {len(places)} "
            f"files in {len(folders)} folders found; open their folder"
        )
    session = Session(Folder.at(folders.pop()), effect_files)
    session.choose(places[0].name, places[1].name if len(places) == 2 else None)
    return session
