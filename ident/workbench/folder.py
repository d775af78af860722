"""The one folder that the page may see."""

from dataclasses import dataclass
from pathlib import Path

from recordings.errors import BadInput

SUFFIX = ".mcap"
_LONGEST_NAME = 120


@dataclass(frozen=True)
class Folder:
    """Names of files in `root`, and nothing outside of it, whatever a name or a link says."""

    root: Path

    @classmethod
    def at(cls, path: Path) -> "Folder":
        """Raises BadInput where `path` is no folder."""
        if not path.is_dir():
            raise BadInput(f"an existing folder or recording expected, {path} found; check the path")
        return cls(path.resolve())

    def recordings(self) -> list[str]:
        """Names of the recordings, in alphabetical order."""
        files = (path for path in self.root.iterdir() if path.suffix == SUFFIX)
        return sorted(path.name for path in files if path.is_file() and self._inside(path))

    def trajectories(self) -> list[str]:
        """Names of files that may hold a motion."""
        files = (path for path in self.root.iterdir() if path.suffix in (".csv", ".toml"))
        return sorted(path.name for path in files if path.is_file() and self._inside(path))

    def path(self, name: str) -> Path:
        """The existing file `name`.

        Raises:
            BadInput: there is none, or it is not in the folder.
        """
        self._refuse(name)
        path = self.root / name
        if not path.is_file() or not self._inside(path):
            raise BadInput(f"a file in {self.root.name}/ expected, '{name}' found; choose one of the list")
        return path

    def new(self, name: str, suffix: str) -> Path:
        """Where a new file `name` is to be written.

        Raises:
            BadInput: the name leads out of the folder, does not end in `suffix`, or is taken.
        """
        self._refuse(name)
        if not name.endswith(suffix) or name == suffix:
            raise BadInput(f"a file name ending in {suffix} expected, '{name}' found; choose another name")
        path = self.root / name
        if path.exists() or path.is_symlink():
            raise BadInput(f"{name} exists, and nothing is overwritten here; choose another name")
        return path

    def _refuse(self, name: str) -> None:
        """What is a name here, is one on every system, and has one meaning."""
        if (
            not name
            or name.startswith(".")
            or len(name) > _LONGEST_NAME
            or any(char in '/\\:*?"<>|' or ord(char) < 32 for char in name)
        ):
            raise BadInput(
                f'a plain file name of up to {_LONGEST_NAME} characters, without / \\ : * ? " < > |, expected, '
                f"'{name[:_LONGEST_NAME]}' found; rename the file"
            )

    def _inside(self, path: Path) -> bool:
        return path.resolve().parent == self.root
