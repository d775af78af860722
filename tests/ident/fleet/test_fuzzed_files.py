"""Every file of the fuzz corpus has its row, with the reason if it cannot be used."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ident.fleet.store import Store
from recordings.errors import BadInput
from tests.fuzz import inputs, recordings
from tests.ident.fleet.conftest import brought_up_to_date

MUTATED, RANDOM = 60, 12


def corpus(folder: Path, sample: Path) -> set[str]:
    """Write mutated copies of `sample` and random recordings; return their paths."""
    rng = np.random.default_rng(18)
    original = sample.read_bytes()
    for number in range(MUTATED):
        (folder / f"mutated-{number}.mcap").write_bytes(inputs.mutated(original, rng))
    for number in range(RANDOM):
        try:
            recordings.write(folder, f"random-{number}", recordings.machine(rng), rng, 600)
        except BadInput:
            continue  # the import refuses it
    return {str(path) for path in folder.glob("*.mcap")}


@pytest.mark.slow
def test_every_file_has_a_row_and_every_failure_its_reason(tmp_path: Path, night: Callable[..., Path]) -> None:
    folder, store = tmp_path / "recordings", Store(tmp_path / "store")
    folder.mkdir()
    paths = corpus(folder, night(tmp_path / "sample.mcap", 0))
    count = brought_up_to_date(store, folder)
    rows = [row for row in store.table().to_pylist() if row["kind"] == "recording"]
    assert {row["path"] for row in rows} == paths
    assert {row["status"] for row in rows} == {"done", "failed"}
    reasons = [row["reason"] for row in rows if row["status"] == "failed"]
    assert len(reasons) == count.failed
    for reason in reasons:
        assert len(reason) > 10
        assert "Error:" not in reason, "an exception that is no sentence to the user"
