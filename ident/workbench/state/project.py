"""What the workbench remembers in a folder: selection, steps, undo and notes, and where its page was."""

import os
import sys
from dataclasses import dataclass, field
from pathlib import Path
from stat import S_ISREG
from typing import Any, Literal

from filelock import FileLock, Timeout
from pydantic import TypeAdapter, ValidationError

from ident.workbench.folder import Folder
from ident.workbench.state.history import History
from recordings.files import replacement

FOLDER = ".delta-workbench"
_SAVED, _NOT_SAVED = f"Kept in {FOLDER} as you work.", "Kept in memory alone: "


@dataclass(frozen=True)
class Kept:
    """A session as it is kept."""

    schema_version: Literal[2] = 2
    train: str | None = None
    validate: str | None = None
    history: History | None = None
    tab: str = "data"
    dark: bool = False
    notes: str = ""
    running: str | None = None
    """File that was being recorded, or the command that moved a joint."""
    fields: dict[str, Any] = field(default_factory=dict)
    """Values of the forms."""
    durations: dict[str, float] = field(default_factory=dict)
    """Time that each task of the worker took [s]."""


@dataclass(frozen=True)
class Access:
    """Port and token of the page: where both are as before, an open tab finds a restarted server."""

    port: int
    token: str


_KEPT, _ACCESS = TypeAdapter(Kept), TypeAdapter(Access)


class Project:
    """Files in `.delta-workbench`, written by one workbench at a time; where that is not possible, memory alone."""

    def __init__(self, root: Path) -> None:
        self._folder = folder = root / FOLDER
        self._content, self._access = folder / "project.json", folder / "access.json"
        # However this program ends, the system releases the lock.
        self._lock = FileLock(folder / "lock", timeout=0, thread_local=False)
        self.says = _SAVED
        """Whether what is done is kept, for the user."""

    def open(self) -> Kept:
        """Keep other workbenches away, and return what was kept; what cannot be read is set aside."""
        try:
            if self._folder.is_symlink():
                raise OSError(0, "it is a link")
            self._folder.mkdir(exist_ok=True)
            self._lock.acquire()
        except Timeout:
            self.says = f"{_NOT_SAVED}another workbench works in this folder."
        except OSError as error:
            self._fail(self._folder, error)
        try:
            return _KEPT.validate_json(self._content.read_bytes()) if self._lock.is_locked else Kept()
        except FileNotFoundError:
            return Kept()
        except (OSError, ValidationError):
            self.set_aside(f"{self._content.name} cannot be read")
            return Kept()

    def set_aside(self, why: str) -> None:
        """Rename what was kept, because of `why` it is not taken up."""
        aside = self._folder / Folder(self._folder).free_name("project-before", ".json")
        try:
            os.replace(self._content, aside)  # noqa: PTH105
            self.says = f"Earlier models were not taken up, and are in {FOLDER}/{aside.name}: {why}."
        except OSError as error:
            self._fail(aside, error)

    def save(self, kept: Kept) -> None:
        """Write `kept`; where that fails, `says` says so."""
        self._write(self._content, _KEPT.dump_json(kept, indent=1))

    def access(self) -> Access | None:
        """Return where the page was; None where nothing says it that others could neither read nor write."""
        try:
            state = self._access.lstat()
            ours = sys.platform == "win32" or (state.st_uid == os.geteuid() and not state.st_mode & 0o077)
            trusted = self._lock.is_locked and ours and S_ISREG(state.st_mode)
            return _ACCESS.validate_json(self._access.read_bytes()) if trusted else None
        except (OSError, ValidationError):
            return None

    def keep_access(self, access: Access) -> None:
        """Write where the page is."""
        self._write(self._access, _ACCESS.dump_json(access))

    def close(self) -> None:
        """Let another workbench work in the folder."""
        self._lock.release()

    def _write(self, path: Path, content: bytes) -> None:
        """Replace the file `path` by one that only its owner can read."""
        if not self._lock.is_locked:
            return
        try:
            with replacement(path) as partial:
                partial.touch(0o600, exist_ok=False)
                partial.write_bytes(content)
            if self.says.startswith(_NOT_SAVED):
                self.says = _SAVED
        except OSError as error:
            self._fail(path, error)

    def _fail(self, path: Path, error: OSError) -> None:
        self.says = f"{_NOT_SAVED}{path.name} cannot be written ({error.strerror})."
