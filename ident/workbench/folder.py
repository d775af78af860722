"""Access to the one folder that the page may read and write."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from delta_web.local import LINK_PREFIX
from recordings.errors import BadInput
from recordings.files import free_name
from recordings.reader import is_foreign

SUFFIX = ".mcap"
FOREIGN_SUFFIXES = (
    ".csv",
    ".txt",
    ".tsv",
    ".dat",
    ".parquet",
    ".feather",
    ".npz",
    ".mat",
    ".h5",
    ".hdf5",
    ".mf4",
    ".tdms",
    ".db3",
)
"""Of files that `daq import` may read, besides ROS bags (.mcap)."""
_BAG_METADATA = "metadata.yaml"
"""File that makes a folder a ROS bag."""
_MAX_NAME_LENGTH = 120


@dataclass(frozen=True)
class Folder:
    """Files directly in `root`. Names and links that lead outside are refused."""

    root: Path

    @classmethod
    def at(cls, path: Path) -> "Folder":
        """Return the folder `path`; raise BadInput if it is not an existing folder."""
        if not path.is_dir():
            raise BadInput(f"an existing folder or recording expected, {path} found; check the path")
        return cls(path.resolve())

    def names(self, *suffixes: str) -> list[str]:
        """Return the names of the files with one of the `suffixes` in alphabetical order."""
        return self._matching(*(f"*{suffix}" for suffix in suffixes))

    def models(self) -> list[str]:
        """Return the names of the models that `ident` has written, in alphabetical order."""
        return self._matching("*.model.json")

    def reports(self) -> list[str]:
        """Return the names of the reports and other pages, in alphabetical order."""
        return [name for name in self.names(".html") if not name.startswith(LINK_PREFIX)]

    def recordings(self) -> list[str]:
        """Return the names of the recordings of this program, and of what cannot be read, in alphabetical order."""
        return [name for name in self.names(SUFFIX) if not self.is_foreign(name)]

    def foreign(self) -> list[str]:
        """Return the names of the files and folders (ROS bags) that `daq import` may turn into recordings."""
        bags = (path.parent for path in self.root.glob(f"*/{_BAG_METADATA}"))
        names = [name for name in self.names(SUFFIX, *FOREIGN_SUFFIXES) if self.is_foreign(name)]
        return sorted([*names, *(bag.name for bag in bags if self._inside(bag))])

    def is_foreign(self, name: str) -> bool:
        """Return whether another program wrote the file `name`."""
        path = self.root / name
        if path.suffix != SUFFIX:
            return path.suffix in FOREIGN_SUFFIXES
        try:
            state = path.stat()
        except OSError:  # deleted meanwhile
            return False
        return _is_foreign_mcap(path, state.st_mtime_ns, state.st_size)

    def existing_file(self, name: str) -> Path:
        """Return the path of the existing file `name`.

        Raises:
            BadInput: there is no such file in the folder.
        """
        self._check_name(name)
        path = self.root / name
        if not path.is_file() or not self._inside(path):
            raise BadInput(f"a file in {self.root.name}/ expected, '{name}' found; choose one from the list")
        return path

    def report(self, name: str) -> Path:
        """Return the path of the report `name`.

        Raises:
            BadInput: there is no such report in the folder.
        """
        path = self.existing_file(name)
        if name not in self.reports():
            raise BadInput(f"a report expected, '{name}' found; choose one from the list")
        return path

    def new_file(self, name: str, suffix: str, *, numbered: bool = False) -> Path:
        """Return the path for a new file `name`; `numbered`: with a number where that exists.

        Raises:
            BadInput: the name leads out of the folder, does not end in `suffix`, or exists already.
        """
        self._check_name(name)
        if not name.endswith(suffix) or name == suffix:
            raise BadInput(f"a file name ending in {suffix} expected, '{name}' found; choose another name")
        path = free_name(self.root / name, suffix) if numbered else self.root / name
        if path.exists() or path.is_symlink():
            raise BadInput(f"a new file name expected, {name} exists and is not overwritten; choose another name")
        return path

    def free_name(self, stem: str, suffix: str) -> str:
        """Return a name for a new file or folder: the stem, with a number where such a name is taken."""
        return free_name(self.root / f"{stem}{suffix}", suffix).name

    def _matching(self, *patterns: str) -> list[str]:
        files = {path for pattern in patterns for path in self.root.glob(pattern)}
        return sorted(path.name for path in files if path.is_file() and self._inside(path))

    def _check_name(self, name: str) -> None:
        """Refuse names that are not plain file names on every operating system."""
        if (
            not name
            or name.startswith(".")
            or len(name) > _MAX_NAME_LENGTH
            or any(char in '/\\:*?"<>|' or ord(char) < 32 for char in name)
        ):
            raise BadInput(
                f'a plain file name of up to {_MAX_NAME_LENGTH} characters, without / \\ : * ? " < > |, expected, '
                f"'{name[:_MAX_NAME_LENGTH]}' found; choose another name"
            )

    def _inside(self, path: Path) -> bool:
        return path.resolve().parent == self.root


@lru_cache(maxsize=4096)
def _is_foreign_mcap(path: Path, mtime_ns: int, size: int) -> bool:
    """Return `is_foreign`, kept while the file does not change; False for what cannot be read."""
    try:
        return is_foreign(path)
    except BadInput:  # said when it is chosen
        return False
