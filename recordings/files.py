"""Files: creation, replacement in one step, and the digest that identifies a content."""

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedWriter
from pathlib import Path

from recordings.errors import BadInput, RunFailed


def sha256(path: Path) -> str:
    """Return the SHA-256 of the file `path` as hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def create(path: Path, what: str = "recording") -> BufferedWriter:
    """Create a new file; `what` names its kind in errors.

    Raises:
        BadInput: the file exists, or cannot be created.
    """
    try:
        return path.open("xb")
    except FileExistsError:
        raise BadInput(f"{what} {path} exists; choose another name or remove it") from None
    except FileNotFoundError:
        if path.parent.is_dir():  # as /proc
            raise BadInput(f"folder {path.parent} takes no new files; choose another one for {what} {path}") from None
        raise BadInput(f"folder {path.parent} does not exist; create it or choose another name") from None
    except OSError as error:
        raise BadInput(f"{what} {path} cannot be created: {error.strerror}; choose another name") from None


@contextmanager
def new_file(path: Path, what: str = "recording") -> Iterator[BufferedWriter]:
    """Create a new file, as `create`; after an error in the block it is removed."""
    with create(path, what) as stream:
        try:
            yield stream
        except BaseException:
            path.unlink()
            raise


@contextmanager
def replacement(path: Path) -> Iterator[Path]:
    """Yield the name of a new file that replaces `path` at the end of the block; after an error `path` is unchanged.

    Errors name `path`, because the user does not know the other name.
    """
    partial = path.with_name(path.name + ".part")
    partial.unlink(missing_ok=True)  # of an attempt that was killed
    try:
        yield partial
        os.replace(partial, path)  # noqa: PTH105
    except (BadInput, RunFailed) as error:
        raise type(error)(str(error).replace(str(partial), str(path))) from None
    finally:
        partial.unlink(missing_ok=True)
