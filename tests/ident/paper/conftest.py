"""All methods on a short recording with the friction of Eq. (36)."""

from collections.abc import Callable
from pathlib import Path

import pytest

from ident.paper import methods
from ident.paper.methods import MethodComparison
from recordings.recording import Recording


@pytest.fixture(scope="session")
def recorded(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("table2")
    recordings = [
        make(name, cycles=1, rate=250.0, noise=0.02, path=folder / f"{name}.mcap") for name in ("fig5a", "fig5b")
    ]
    return write(recordings[0]), write(recordings[1])


@pytest.fixture(scope="session")
def comparison(recorded: tuple[Path, Path]) -> MethodComparison:
    return methods.compare_methods(recorded, "central", 0, lambda *_: None)
