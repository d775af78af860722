"""Access to the one folder that the page may read and write."""

from dataclasses import dataclass
from pathlib import Path

from recordings.errors import BadInput

SUFFIX = ".mcap"
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
        files = (path for path in self.root.iterdir() if path.suffix in suffixes)
        return sorted(path.name for path in files if path.is_file() and self._inside(path))

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

    def new_file(self, name: str, suffix: str) -> Path:
        """Return the path for a new file `name`.

        Raises:
            BadInput: the name leads out of the folder, does not end in `suffix`, or exists already.
        """
        self._check_name(name)
        if not name.endswith(suffix) or name == suffix:
            raise BadInput(f"a file name ending in {suffix} expected, '{name}' found; choose another name")
        path = self.root / name
        if path.exists() or path.is_symlink():
            raise BadInput(f"a new file name expected, {name} exists and is not overwritten; choose another name")
        return path

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
                f"'{name[:_MAX_NAME_LENGTH]}' found; rename the file"
            )

    def _inside(self, path: Path) -> bool:
        return path.resolve().parent == self.root
