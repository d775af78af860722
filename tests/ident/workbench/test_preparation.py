"""A recording is changed by the command that the page shows, and what the page runs can be cancelled."""

import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from ident.workbench.programs import file_import
from ident.workbench.programs.file_import import EXCLUDE, KEEP, NEGATE, SWAP, UNIT
from ident.workbench.programs.running import Cancellable, run
from recordings.columns import columns
from recordings.errors import BadInput
from recordings.importing import Description, import_data
from recordings.reader import read
from tests.ident.workbench.test_session import SAMPLES

SAMPLE = SAMPLES / "fig5b.mcap"


@pytest.mark.parametrize(
    ("what", "quantity", "joints", "other", "expected"),
    [
        (KEEP, "position", [1], "", "--trim 1.500:4.000"),
        (EXCLUDE, "position", [1], "", "--exclude 1.500:4.000"),
        (NEGATE, "voltage", [2], "", "--map voltage_2=voltage_2:*-1"),
        (NEGATE, "position", [2], "", "--map position_2=position_2:*-1 --map velocity_2=velocity_2:*-1"),
        (SWAP, "voltage", [1], "3", "--map voltage_1=voltage_3 --map voltage_3=voltage_1"),
        (UNIT, "position", [1], "deg", "--map position_1=position_1:deg --map velocity_1=velocity_1:deg/s"),
    ],
)
def test_preparation_is_a_command(what: str, quantity: str, joints: list[int], other: str, expected: str) -> None:
    columns = [f"{name}_{joint}" for name in ("position", "velocity", "voltage") for joint in (1, 2, 3)]
    words = file_import.preparation(columns, what, (1.5, 4.0), quantity, joints, other)
    assert words == expected.split()


@pytest.mark.parametrize(("what", "sign"), [(NEGATE, -1), (SWAP, 1)])
def test_prepared_recording_is_the_other_one_changed(what: str, sign: int, tmp_path: Path) -> None:
    before = read(SAMPLE)
    words = file_import.preparation([*columns(before)], what, (0.0, 1.0), "voltage", [1], "2")
    import_data(SAMPLE, tmp_path / "out.mcap", Description(), mapping=words[1::2])
    column = 1 if what == SWAP else 0
    np.testing.assert_allclose(read(tmp_path / "out.mcap").voltage[:, 0], sign * before.voltage[:, column])


STUBBORN = """
import pathlib, time
half = pathlib.Path("half")
half.touch()
try:
    time.sleep(600)
finally:
    half.unlink()
"""


@pytest.mark.parametrize("early", [False, True])
def test_cancelled_program_tidies_up(early: bool, tmp_path: Path) -> None:
    running = Cancellable()
    if early:
        running.cancel()
    with ThreadPoolExecutor() as pool:
        result = pool.submit(running.call, run, tmp_path, (sys.executable, "-c", STUBBORN), ["import"], None)
        while not (early or (tmp_path / "half").exists()):
            time.sleep(0.01)
        running.cancel()
        with pytest.raises(BadInput, match=r"Cancelled \(import\)"):
            result.result()
    assert not (tmp_path / "half").exists()
