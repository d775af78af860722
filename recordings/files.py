"""Files: creation, names that are free, replacement in one step, and the digest that identifies a content."""

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedWriter
from itertools import chain, count
from pathlib import Path

from recordings.errors import BadInput, RunFailed


def sha256(path: Path) -> str:
    """Return the SHA-256 of the file `path` as hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def free_name(path: Path, ending: str | None = None) -> Path:
    """`path`, or, if it exists, a name beside it that does not: "a.diagnose-2.html", "a-2.model.json".

    ending: what stands behind the number; None: the suffix, or that of a model.
    """
    if ending is None:
        ending = ".model.json" if path.name.endswith(".model.json") else path.suffix
    stem = path.name.removesuffix(ending)
    names = chain([path], (path.with_name(f"{stem}-{number}{ending}") for number in count(2)))
    return next(name for name in names if not os.path.lexists(name))


def check_new(path: Path, force: bool = False, to_replace: str = "force=True") -> None:
    """Check that an output replaces nothing without `force`; to_replace: how the user says that it should.

    Raises:
        BadInput: the file or folder exists, and `force` is False.
    """
    if not force and os.path.lexists(path):
        raise BadInput(f"a new name expected, {path} exists; give another one, or {to_replace} to replace it")


def create(path: Path, what: str = "recording") -> BufferedWriter:
    """Create a new file; `what` names its kind in errors.

    Raises:
        BadInput: the file exists, or cannot be created.
    """
    try:
        return path.open("xb")
    except FileExistsError:
        raise BadInput(f"a new name expected, {what} {path} exists; give another one, or remove it") from None
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
