import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from ident.program import program
from recordings.errors import BadInput
from recordings.recording import Floats, Recording
from recordings.rig import Torque, load_rig, simulated_rig
from tests.conftest import Runner
from tests.running import ran

GAINS = (0.8, 1.0, 1.3)


@pytest.fixture(scope="module")
def pair(
    make: Callable[..., Recording],
    write: Callable[[Recording], Path],
    truth: Floats,
    tmp_path_factory: pytest.TempPathFactory,
) -> tuple[Path, Path]:
    """Recordings without and with 1.5 kg, by drives whose gains are not those of the rig file."""
    folder = tmp_path_factory.mktemp("pair")
    rig = simulated_rig()
    true = rig.model_copy(update={"torque": Torque(gain=GAINS)})
    files = []
    for seed, (name, payload) in enumerate((("empty", 0.0), ("loaded", 1.5))):
        parameters = truth + payload * np.eye(len(truth))[0]
        recording = make(
            rig=true, parameters=parameters, cycles=1, noise=0.02, seed=seed, path=folder / f"{name}.mcap"
        )
        files.append(write(replace(recording, rig=rig)))
    return files[0], files[1]


calibrate = partial(ran, program, "calibrate-gain")


def test_printed_section_is_valid_in_a_rig_file(pair: tuple[Path, Path], tmp_path: Path) -> None:
    result = calibrate(*pair, "--payload", 1.5, "-o", tmp_path / "torque.toml")
    assert result.stdout == (tmp_path / "torque.toml").read_text()
    rig_file = tmp_path / "rig.toml"
    rig_file.write_text(
        'name = "bench"\n' + "".join(f"[[drives]]\nnode_id = {i}\n" for i in (1, 2, 3)) + result.stdout
    )
    torque = load_rig(rig_file).torque
    np.testing.assert_allclose(torque.gain, GAINS, rtol=0.02)
    assert torque.gain_source == "calibrated"
    assert 0 < torque.gain_uncertainty < 0.02
    for text in (
        "SIMULATED",
        "joint 3: 1.3",
        "differ between joints, by up to 6",
        "The payload explains",
        "10 mm more of L2",
    ):
        assert text in result.stderr


def test_bad_input_is_explained(pair: tuple[Path, Path]) -> None:
    with pytest.raises(BadInput, match="exchange the two files"):
        calibrate(*reversed(pair), "--payload", 1.5)


@pytest.mark.slow
def test_gains_of_the_simulated_rig_are_found_and_make_a_fit_absolute(
    daq: Runner, ident: Runner, tmp_path: Path
) -> None:
    """The plant has forearms with mass, which the model lumps: the model error must cancel."""
    for seed, (name, payload) in enumerate((("empty", 0.0), ("loaded", 1.5))):
        sim = tmp_path / f"{name}.toml"
        sim.write_text(f"torque_gain = {list(GAINS)}\n[links]\npayload = {payload}\n")
        record = ("record", "--traj", "fig5a", "--cycles", 2, "--seed", seed, "--sim", sim, "--out", f"{name}.mcap")
        assert daq(*record).code == 0
    result = ident("calibrate-gain", "empty.mcap", "loaded.mcap", "--payload", 1.5, "--json")
    document = json.loads(result.out)
    for gain, (lowest, highest), value in zip(GAINS, document["gain_ci95"], document["torque"]["gain"], strict=True):
        assert lowest < gain < highest
        assert value == pytest.approx(gain, rel=0.005)
