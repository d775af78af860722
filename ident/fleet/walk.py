"""Find the recordings below folders, and recognise those whose content is known from an earlier run."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ident.fleet.places import State, files
from recordings.errors import BadInput
from recordings.files import sha256

SUFFIX = ".mcap"
_UNFINISHED = ".part"
"""Part of the names of files that another program is still writing."""

FileState = tuple[str, int, int]
"""Path, size and time of the last change [ns] of a file: as long as these are the same, its content is."""


@dataclass(frozen=True)
class RecordingFile:
    """A file that should be a recording."""

    path: Path
    content: str
    """SHA-256 of its content; empty if it cannot be read."""
    size: int
    changed: int
    """Time of the last change [ns]."""


def walk(folders: Sequence[Path], known: Mapping[FileState, str] | None = None) -> Iterator[RecordingFile]:
    """Yield all recordings below `folders`, at any depth, sorted by path.

    known: SHA-256 of files that were read before. A link to a folder is not followed.

    Raises:
        BadInput: a folder does not exist.
    """
    check_folders(folders)
    found = {path: state for folder in folders for path, state in files(folder).items() if _is_recording(path.name)}
    for path in sorted(found, key=lambda path: path.parts):
        yield _described(path, found[path], known or {})


def check_folders(folders: Sequence[Path]) -> None:
    """Check that all `folders` exist and none is a store, before a store is created.

    Raises:
        BadInput: one of them does not exist, or is a store.
    """
    for folder in folders:
        if not folder.is_dir():
            raise BadInput(f"{folder}: a folder of recordings expected, none found; check the path")
        if is_store(folder):
            raise BadInput(
                f"{folder}: a folder of recordings expected, a store of `ident fleet` found; "
                f"`ident fleet report --store {folder} -o fleet.html` shows it"
            )


def is_store(folder: Path) -> bool:
    """Whether a folder is a store of `ident fleet`, with results in it."""
    return any((folder / "recordings").rglob("*.parquet"))


def _is_recording(name: str) -> bool:
    return name.endswith(SUFFIX) and _UNFINISHED not in Path(name).suffixes and not name.startswith(".")


def _described(path: Path, state: State | None, known: Mapping[FileState, str]) -> RecordingFile:
    try:
        size, changed = state or _state(path)
        return RecordingFile(path, known.get((str(path), size, changed)) or sha256(path), size, changed)
    except OSError:
        return RecordingFile(path, "", 0, 0)


def _state(path: Path) -> State:
    status = path.stat()
    return status.st_size, status.st_mtime_ns
