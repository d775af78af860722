"""Creation of a session from the arguments of `ident workbench`."""

from collections.abc import Sequence
from pathlib import Path

from ident.workbench.folder import SUFFIX, Folder
from ident.workbench.session import WorkbenchSession
from recordings.errors import BadInput


def open_session(paths: Sequence[Path], effect_files: Sequence[Path] = ()) -> WorkbenchSession:
    """Open a session on one folder, or on the folder of one or two recordings and choose these.

    Raises:
        BadInput: a path does not exist, or the recordings are not in one folder.
    """
    if not paths or (len(paths) == 1 and paths[0].is_dir()):
        return WorkbenchSession(Folder.at(paths[0] if paths else Path()), effect_files)
    for path in paths:
        if not path.is_file() or path.suffix != SUFFIX:
            raise BadInput(f"a folder, or existing recordings ({SUFFIX}), expected, {path} found; check the path")
    folders = {path.absolute().parent.resolve() for path in paths}
    if len(paths) > 2 or len(folders) > 1:
        raise BadInput(
            f"one folder, or a recording to fit and one to validate on in the same folder, expected, {len(paths)} "
            f"files in {len(folders)} folders found; open their folder"
        )
    session = WorkbenchSession(Folder.at(folders.pop()), effect_files)
    session.choose(paths[0].name, paths[1].name if len(paths) == 2 else None)
    return session
