"""What follows from the samples of a recording."""

from dataclasses import replace

import numpy as np
import pytest

from recordings.recording import IMPORTED, Floats, Recording
from tests.ident import building

NAN = np.nan


def commanded(command: Floats, position: Floats, trajectory: str = "fig5a") -> Recording:
    recording = building.record()
    run = recording.run.model_copy(update={"trajectory": trajectory})
    return replace(recording, run=run, command=command[:, None], position=position[:, None])


def error(command: list[float], position: list[float], trajectory: str = "fig5a") -> list[float]:
    recording = commanded(np.array(command), np.array(position), trajectory)
    return [float(value) for value in recording.following_error[:, 0]]


def test_an_answer_shows_how_the_target_of_the_cycle_before_was_reached() -> None:
    np.testing.assert_allclose(error([0.0, 1.0, 2.0, 3.0], [0.0, 0.0, 0.9, 2.0]), [NAN, 0.0, 0.1, 0.0])


def test_the_last_target_stays_while_cycles_are_missed() -> None:
    command, position = [1.0, 2.0, NAN, NAN, 3.0, 4.0], [0.0, 1.0, NAN, NAN, 1.9, 3.0]
    np.testing.assert_allclose(error(command, position), [NAN, 0.0, NAN, NAN, 0.1, 0.0])


def test_before_and_after_the_motion_there_is_none() -> None:
    np.testing.assert_allclose(error([NAN, 1.0, 2.0, NAN], [1.0, 1.0, NAN, 2.0]), [NAN, NAN, NAN, NAN])


def test_imported_targets_are_of_the_same_instant() -> None:
    assert error([1.0, 2.0], [0.9, 2.0], IMPORTED) == pytest.approx([0.1, 0.0])
