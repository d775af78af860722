"""Where recordings and stores are: folders of this machine (NFS, too), or object stores, by URLs such as s3://bucket.

A place in an object store is a UPath, which has the methods of a Path and goes by its type. All else in which the two
differ is here: how files are listed and read, how one is written whole or not at all, and how one program at a time
writes.
"""

import os
import socket
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import replace
from datetime import UTC, datetime
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path, PosixPath, WindowsPath
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, TypeGuard, cast

from filelock import FileLock, Timeout

from recordings.errors import BadInput
from recordings.files import replacement, sha256
from recordings.reader import Source, read

if TYPE_CHECKING:
    from upath import UPath

State = tuple[int, int]
"""Size of a file [bytes], and time of its last change [ns]."""
_PACKAGES = {"s3": "s3fs", "gs": "gcsfs", "memory": "fsspec"}
"""Package of each protocol; each can put an object on condition that there is none, which keeps writers apart."""
_CHANGED = ("LastModified", "mtime", "created")
"""Names of the time of an object's last change in these packages."""
_LIBRARIES = {*_PACKAGES.values(), "aiobotocore", "aiohttp", "botocore"}
"""Packages whose errors say that an object store is lost."""


def place(text: str) -> Path:
    """The place that is named by a path or by a URL.

    Raises:
        BadInput: its protocol is unknown, or the package for it is not installed.
    """
    protocol, is_url, rest = text.partition("://")
    if not is_url or protocol == "file":
        return Path(rest or text)
    if protocol not in _PACKAGES:
        raise BadInput(f"{text}: a path, s3:// or gs:// expected, {protocol}:// found; choose another place")
    for package in ("upath", _PACKAGES[protocol]):
        if find_spec(package) is None:
            # Of memory://, both are in each of the extras.
            extra = "s3" if protocol == "memory" else protocol
            raise BadInput(
                f"{text} needs the package {package}, which is not installed; install it with "
                f"`pip install 'delta-workbench[{extra}]'`"
            )
    from upath import UPath

    return cast(Path, UPath(text, use_listings_cache=False))  # other programs write there, too


def reached(text: str) -> Path:
    """The place that is named by a path or by a URL; an object store has answered, whether or not it is there.

    Raises:
        BadInput: as `place`; or the store does not answer, or refuses, as without credentials.
    """
    found = place(text)
    if in_object_store(found):
        with _errors(found, "reached"), suppress(FileNotFoundError):
            found.fs.info(found.path)
    return found


def in_object_store(where: Path) -> "TypeGuard[UPath]":
    """Whether a place is in an object store, not on this machine."""
    return not isinstance(where, PosixPath | WindowsPath)


def files(folder: Path) -> dict[Path, State | None]:
    """All files below a `folder`, at any depth, with their states if listing them tells; links are not followed."""
    if not in_object_store(folder):
        found = (Path(within).absolute() / name for within, _, names in os.walk(folder) for name in names)
        return dict.fromkeys(found)
    with _errors(folder, "read"):
        listed = folder.fs.find(folder.path, detail=True)
    below = {name.removeprefix(folder.path).lstrip("/"): info for name, info in listed.items()}
    return {cast(Path, folder / name): (info["size"], _changed(info)) for name, info in below.items()}


def _changed(info: Mapping[str, Any]) -> int:
    time = next(info[name] for name in _CHANGED if name in info)
    return int((time.timestamp() if isinstance(time, datetime) else time) * 1e9)


def content(where: Path) -> Path | BytesIO:
    """The file, or the bytes of the object, for pyarrow.

    Raises:
        BadInput: an object cannot be read.
    """
    if not in_object_store(where):
        return where
    with _errors(where, "read"):
        return BytesIO(where.read_bytes())


def source(where: Path) -> Source:
    """What readers take: a file, or what is recorded in an object, which is fetched once for all of them.

    Raises:
        BadInput: an object cannot be read, or is no recording.
    """
    if not in_object_store(where):
        return where
    with TemporaryDirectory() as folder:  # a reader of MCAP goes to and fro
        local = Path(folder) / where.name
        with _errors(where, "read"):
            where.fs.get_file(where.path, str(local))
        try:
            return replace(read(local), path=cast(Path, where), known_digest=sha256(local))
        except BadInput as error:
            raise BadInput(str(error).replace(str(local), str(where))) from None


@contextmanager
def whole(where: Path) -> Iterator[Path]:
    """Yield the name of a new file that becomes `where` at the end of the block; an error leaves it unchanged.

    Raises:
        BadInput: an object cannot be written.
        OSError: a file cannot.
    """
    if in_object_store(where):
        with TemporaryDirectory() as folder:
            partial = Path(folder) / where.name
            yield partial
            with _errors(where, "written"):
                where.fs.put_file(str(partial), where.path)  # there when all of it is
    else:
        where.parent.mkdir(parents=True, exist_ok=True)
        with replacement(where) as partial:
            yield partial


def write(where: Path, data: bytes) -> None:
    """Write a file whole, or leave it unchanged.

    Raises:
        BadInput: it cannot be written.
    """
    try:
        with whole(where) as partial:
            partial.write_bytes(data)
    except OSError as error:
        raise BadInput(f"{where} cannot be written: {error.strerror}; make room, and run again") from None


def make_folder(folder: Path) -> None:
    """Create a `folder`, if there is none."""
    if in_object_store(folder):
        (folder / ".keep").touch()  # object stores have no empty folders
    else:
        folder.mkdir(parents=True, exist_ok=True)


def one_writer(folder: Path) -> AbstractContextManager[None]:
    """Keep other programs away from the store in `folder`, which is created.

    Raises:
        BadInput: another one uses it, it cannot be written, or nothing keeps two writers apart.
    """
    return _object_lock(folder) if in_object_store(folder) else _file_lock(folder)


@contextmanager
def _file_lock(folder: Path) -> Iterator[None]:
    """A lock of the operating system, which ends with its process."""
    lock = FileLock(folder / ".lock", timeout=0)
    try:
        make_folder(folder)
        lock.acquire()
    except Timeout:
        raise BadInput(f"store {folder} is in use by another `ident fleet`; wait until it ends") from None
    except OSError as error:
        raise BadInput(f"store {folder} cannot be written: {error.strerror}; choose another place") from None
    try:
        yield
    finally:
        lock.release()


@contextmanager
def _object_lock(folder: "UPath") -> Iterator[None]:
    """An object that is put on condition that there is none; one that was killed leaves it."""
    lock = folder / ".lock"
    holder = f"process {os.getpid()} on {socket.gethostname()} since {datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ}"
    if not _put_once(lock, holder):
        raise BadInput(
            f"store {folder} is in use by another `ident fleet`, {lock.read_text()}; wait until it ends, or remove "
            f"{lock} if it was killed"
        )
    try:
        if _put_once(lock, holder):  # as servers do that ignore the condition
            raise BadInput(
                f"store {folder}: an object store with conditional puts (If-None-Match) expected, which keep two "
                "runs from writing at once, none found; choose another place"
            )
        yield
    finally:
        with _errors(lock, "removed"):
            lock.unlink(missing_ok=True)


def _put_once(where: "UPath", text: str) -> bool:
    """Put an object; False if there is one."""
    with _errors(where, "written"):
        try:
            where.fs.pipe_file(where.path, text.encode(), mode="create")
        except OSError:  # servers say in several ways that there is one
            if not where.exists():
                raise
            return False
        return True


@contextmanager
def connected() -> Iterator[None]:
    """Raise BadInput where an object store is lost in the block, be it while it is listed or asked for an object."""
    try:
        yield
    except Exception as error:
        if type(error).__module__.partition(".")[0] not in _LIBRARIES:
            raise
        with _errors("the object store", "reached"):
            raise


@contextmanager
def _errors(where: object, done: str) -> Iterator[None]:
    """Raise BadInput for the errors of the block: each package has classes of its own."""
    try:
        yield
    except Exception as error:
        reason = " ".join(str(error).split())
        raise BadInput(
            f"{where} cannot be {done}: {reason}; check its name, credentials and permissions, and run again"
        ) from None
