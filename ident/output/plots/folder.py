"""Write a folder of pictures completely or not at all."""

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def staged_folder(folder: Path, stale: Sequence[str] = ()) -> Iterator[Path]:
    """Yield a temporary folder to draw into; at the end, unless an error occurs, its pictures move to `folder`.

    stale: name patterns of old pictures that are deleted from `folder` then, as they would be taken for new ones.
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
