"""Part of `make fuzz`: only typed errors occur, and the number of refused inputs is plausible."""

from pathlib import Path

import numpy as np
import pytest

from tests.fuzz import diagnoses, files, inputs, recovery


def test_driver_survives_random_frames() -> None:
    assert inputs.frames_to_the_driver(4000, 11) == 200


def test_simulated_drive_survives_random_frames() -> None:
    assert inputs.frames_to_a_drive(4000, 12) > 50


def test_random_serial_replies_are_parsed_or_refused() -> None:
    assert 1000 < inputs.serial_replies(4000, 13) < 4000


@pytest.mark.slow
def test_damaged_files_of_all_kinds_are_read_or_refused_in_a_sentence() -> None:
    outcomes = list(files.attack(200, 14, processes=2))
    assert not [(outcome.seed, outcome.failure) for outcome in outcomes if outcome.failure]
    assert 100 < sum(bool(outcome.refusal) for outcome in outcomes) < 200


@pytest.mark.slow
def test_what_was_not_hit_of_damaged_recordings_is_kept_and_losses_are_stated(tmp_path: Path) -> None:
    seed = np.random.SeedSequence().generate_state(1).item()
    outcomes = recovery.recover_all(60, seed, tmp_path)
    print(f"seed {seed}: {dict(outcomes)}")
    assert outcomes["rows lost, stated"] > 5


@pytest.mark.slow
def test_random_recordings_are_diagnosed_or_refused_in_a_sentence(tmp_path: Path) -> None:
    outcomes = {seed: diagnoses.run(seed, tmp_path, rows=600) for seed in range(30)}
    assert not {seed: outcome.failure for seed, outcome in outcomes.items() if outcome.failure}
    assert sum(not outcome.refusal for outcome in outcomes.values()) > 5
