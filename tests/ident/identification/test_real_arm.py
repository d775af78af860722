"""Real arms, where their data are: our first step beside plain least squares, written apart."""

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.basics import slicing
from ident.identification.prediction import predict
from recordings.importing import Description, import_data
from recordings.reader import read
from recordings.recording import Recording
from recordings.rig import load_rig

pytest.importorskip("pinocchio")

from benchmarks.real.plain_regression import PlainRegression, rms

DATA = Path(os.environ.get("REAL_DATA", Path(__file__).parents[3].parent / "shared" / "data"))
RIG = """name = "arm"
mechanism = "urdf"
urdf = "{urdf}"
joints = {joints}
"""
TRAIN = 0.6
"""Share of a single recording that trains."""

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not DATA.is_dir(), reason="the data are not here")]


def imported(urdf: Path, joints: Sequence[str], tables: Sequence[Path], folder: Path) -> list[Recording]:
    (folder / "rig.toml").write_text(RIG.format(urdf=urdf, joints=json.dumps(list(joints))), encoding="utf-8")
    description = Description(rig=load_rig(folder / "rig.toml", driven=False))
    for table in tables:
        import_data(table, folder / f"{table.stem}.mcap", description)
    return [read(folder / f"{table.stem}.mcap") for table in tables]


def kuka(folder: Path) -> tuple[Path, list[Recording]]:
    """Six joints; identified on the first motion, held out on two others."""
    data = DATA / "kuka_kr300"
    tables = [data / f"trajectory_{name}.csv" for name in "abc"]
    return data / "kr300.urdf", imported(data / "kr300.urdf", [f"joint_{i}" for i in range(1, 7)], tables, folder)


def pendulum(folder: Path) -> tuple[Path, list[Recording]]:
    """Two joints; the end of one recording is held out."""
    data = DATA / "double_pendulum"
    (whole,) = imported(data / "arm.urdf", ("shoulder", "elbow"), [data / "A0_long75s.csv"], folder)
    train = whole.time - whole.time[0] < TRAIN * np.ptp(whole.time)
    return data / "arm.urdf", [slicing.along_time(whole, rows) for rows in (train, ~train)]


@pytest.mark.parametrize(("arm", "gained"), [(kuka, 0.85), (pendulum, 1.0)])
def test_first_step_is_no_worse_than_plain_least_squares(
    arm: Callable[[Path], tuple[Path, list[Recording]]], gained: float, tmp_path: Path
) -> None:
    """Links that stay bodies tell another motion better, but not every joint of it."""
    urdf, (train, *held_out) = arm(tmp_path)
    model = ident.fit([train], method="wls")
    assert model.identification is not None
    prepared = model.identification.train[0].prepared
    plain = PlainRegression(urdf.read_text(encoding="utf-8"), train.rig.joints, [prepared])
    for prediction in predict(model.file, held_out, model.library):
        ours, theirs = rms(prediction.residual), rms(plain.residual(prediction.prepared))
        assert (ours <= 1.05 * theirs).all(), (prediction.prepared.recording.path.name, ours / theirs)
        assert np.exp(np.mean(np.log(ours / theirs))) <= 1.01 * gained
