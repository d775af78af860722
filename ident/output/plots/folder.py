"""A folder of pictures that is there whole or not at all."""

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def staged_folder(folder: Path, stale: Sequence[str] = ()) -> Iterator[Path]:
    """A folder beside `folder` to draw into; its pictures go to `folder` at the end, unless something went wrong.

    stale: patterns of names; pictures there that are not drawn anew are removed, as they would be taken for new ones.
    """
    folder = folder.resolve()
    partial = folder.with_name(folder.name + ".part")
    try:
        partial.mkdir(parents=True, exist_ok=True)
        yield partial
        folder.mkdir(exist_ok=True)
        for old in (old for pattern in stale for old in folder.glob(pattern)):
            old.unlink()
        for picture in partial.iterdir():
            picture.replace(folder / picture.name)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
