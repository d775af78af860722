"""The sample recording, and the same as a file of other programs."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from recordings.reader import read
from recordings.recording import Recording

SAMPLES = Path(__file__).parents[3] / "recordings" / "samples"


@pytest.fixture(scope="session")
def sample() -> Recording:
    return read(SAMPLES / "fig5a.mcap")


@pytest.fixture(scope="session")
def foreign_file(
    sample: Recording, tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str], tuple[Path, list[str]]]:
    """The file of a kind in `foreign.FILES`, made once, and its options."""
    from tests.recordings.importing.foreign import FILES

    @cache
    def file(kind: str) -> tuple[Path, list[str]]:
        make, options = FILES[kind]
        return make(sample, tmp_path_factory.mktemp("foreign")), options

    return file
