"""Python API: what its objects take and give, from arrays in memory to a model in another process."""

import multiprocessing
import pickle
import runpy
import sys
from concurrent.futures import ProcessPoolExecutor
from operator import methodcaller
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.identification.model import Model
from recordings import reader
from recordings.importing import Description, import_data
from recordings.recording import Recording
from tests.documents import ROOT
from tests.ident.building import DRAG, bench, drag, record

SIGNALS = ("time", "position", "command", "effort", "repeat", "statusword", "rig")


def measured(shape: int) -> Recording:
    """A recording of arrays: an axis with quadratic friction, which the base model lacks."""
    made = record(noise=0.01, extra=drag, shape=shape, seed=shape)
    return ident.Recording.from_arrays(made.time, made.position, effort=made.effort, cycle=made.repeat, rig=made.rig)


@pytest.fixture(scope="module")
def train() -> Recording:
    return measured(0)


@pytest.fixture(scope="module")
def other() -> Recording:
    return measured(1)


@pytest.fixture(scope="module")
def model(train: Recording, other: Recording) -> Model:
    return ident.fit(train, validate=other, method="ls", effects=["quadratic_friction"])


def test_arrays_frames_and_files_give_the_same_recording(train: Recording, tmp_path: Path) -> None:
    frame = train.to_frame()
    frame.to_csv(tmp_path / "a.csv", index=False)
    import_data(tmp_path / "a.csv", tmp_path / "a.mcap", Description(rig=train.rig))
    doors = {
        "frame": ident.Recording.from_frame(frame, rig=train.rig),
        "CSV": ident.read(tmp_path / "a.csv", rig=train.rig),
        "import": ident.read(tmp_path / "a.mcap"),
        "renamed": ident.Recording.from_frame(
            frame.assign(position_1=np.degrees(frame.position_1)).rename(columns={"position_1": "q"}),
            map={"position_1": "q:deg"},
            rig=train.rig,
        ),
    }
    for name, recording in doors.items():
        for signal in SIGNALS:
            expected, found = getattr(train, signal), getattr(recording, signal)
            if signal == "rig":
                assert found == expected, name
            else:
                np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12, err_msg=f"{name}: {signal}")
        assert (recording.run.period, recording.run.cycles) == (train.run.period, train.run.cycles)
    assert len({recording.digest for recording in doors.values()}) == len(doors)
    assert doors["import"].digest != reader.read(tmp_path / "a.mcap").run.trajectory_digest


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"effort": None}, "one of effort, voltage, current expected, none found"),
        ({"voltage": np.zeros(9)}, "effort, voltage found"),
        ({"velocity": np.zeros((8, 1))}, r"velocity: an array \(n, dof\) of shape \(9, 1\) expected"),
        ({"time": np.zeros(9)}, "a time after 0.0 s expected"),
        ({"rig": None}, "three joints of a delta robot expected"),
    ],
)
def test_arrays_that_are_no_recording_are_refused(changes: dict[str, object], message: str) -> None:
    given = {"time": np.arange(9.0), "position": np.zeros(9), "effort": np.ones(9), "rig": bench()} | changes
    with pytest.raises(ident.BadInput, match=message):
        ident.Recording.from_arrays(**given)


def test_the_same_arrays_are_not_used_twice(train: Recording) -> None:
    with pytest.raises(ident.BadInput, match="begin with the same data"):
        ident.fit([train, measured(0)], method="ls")


def test_parameters_have_intervals_units_and_a_covariance(model: Model) -> None:
    drag_found = model.parameters["quadratic_friction.a1"]
    assert drag_found.ci95 is not None
    assert drag_found.ci95[0] < DRAG < drag_found.ci95[1]
    assert (float(drag_found), drag_found.unit) == (drag_found.value, "N m s^2/rad^2")
    covariance, frame = model.covariance, model.to_frame()
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), frame["std"])
    np.testing.assert_array_equal(covariance, covariance.T)
    assert (np.linalg.eigvalsh(covariance) > 0).all()
    assert list(frame.index) == list(model.parameters)
    assert (frame.ci95_low < frame.value).all()


def test_compared_checked_drawn_and_exported(model: Model, other: Recording, tmp_path: Path) -> None:
    residuals = ident.compare(model, other)
    assert residuals.as_json()["verdict"] == "within-noise"
    assert residuals.plot().data
    document = ident.check(other)
    assert {entry.effect: entry.status for entry in document.effects}["quadratic_friction"] == "visible"
    assert model.export("c", tmp_path / "controller", on=other).carried == ("quadratic_friction",)
    assert (tmp_path / "controller" / "delta_model.c").is_file()
    model.save(tmp_path / "m.json")
    with pytest.raises(ident.BadInput, match="the recording of the fit, is not at hand"):
        ident.load_model(tmp_path / "m.json").export("c", tmp_path / "other")


def test_objects_show_a_line_and_a_table_without_markup_of_others(model: Model, train: Recording) -> None:
    odd = ident.Recording.from_frame(
        train.to_frame().rename(columns={"cycle": "<b>"}), rig=train.rig.model_copy(update={"name": "<i>"})
    )
    for shown in (model, ident.compare(model, train), odd):
        assert len(repr(shown)) < 150
        assert "\n" not in repr(shown)
        assert shown._repr_html_().startswith("<table>")
    assert "<i>" not in odd._repr_html_()
    assert "&lt;b&gt;" in odd._repr_html_()


def test_a_frame_without_pandas_says_how_to_get_it(model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ident.BadInput, match="pip install"):
        model.to_frame()


def test_models_work_in_other_processes(model: Model, other: Recording) -> None:
    models = [model, ident.fit(other, method="ls")]
    motion = [np.linspace(-1, 1, 20)[:, None]] * 3
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        found = list(pool.map(methodcaller("torque", *motion), models))
    np.testing.assert_array_equal(found, [each.torque(*motion) for each in models])


@pytest.mark.slow
def test_the_example_names_the_effect_and_its_diagnosis_can_be_pickled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    session = runpy.run_path(str(ROOT / "docs" / "examples" / "arrays_to_model.py"))
    again = pickle.loads(pickle.dumps(session["diagnosis"]))
    assert again.as_json() == session["diagnosis"].as_json()
    assert "quadratic_friction on joints 1" in repr(again)
    assert "quadratic_friction" in again._repr_html_()
    assert again.propose("law.py") is None
    assert not Path("law.py").exists()
    assert again.model.parameters == session["model"].parameters
    assert {path.name for path in tmp_path.iterdir()} >= {"steps.html", "bench.model.json", "controller"}
