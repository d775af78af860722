"""Python API: what its objects take and give, from arrays in memory to a model in another process."""

import multiprocessing
import pickle
import runpy
import signal
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from operator import methodcaller
from pathlib import Path

import numpy as np
import plotly
import pytest

import ident
from ident.identification.model import Model
from ident.program import program
from recordings import reader
from recordings.imported import measured_torque
from recordings.importing import Description, import_data
from recordings.recording import Recording
from tests.documents import ROOT
from tests.ident.building import DRAG, bench, drag, record
from tests.running import ran

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
        for field in SIGNALS:
            expected, found = getattr(train, field), getattr(recording, field)
            if field == "rig":
                assert found == expected, name
            else:
                np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12, err_msg=f"{name}: {field}")
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
    for on in (None, other):
        assert model.export("c", tmp_path / "controller", on=on, force=True).carried == ("quadratic_friction",)
    assert (tmp_path / "controller" / "delta_model.c").is_file()
    model.save(tmp_path / "m.json")
    with pytest.raises(ident.BadInput, match="the recording of the fit, is not at hand"):
        ident.load_model(tmp_path / "m.json").export("c", tmp_path / "other")


def test_a_model_and_a_recording_are_drawn_and_reported(
    model: Model, train: Recording, other: Recording, tmp_path: Path
) -> None:
    for figure, names in ((model.plot(), {"measured", "model"}), (train.plot(), {"joint 1"})):
        assert names <= {trace.name for trace in figure.data}
        assert isinstance(figure, plotly.graph_objects.Figure)
    assert model.plot(other).data[0].y.tolist() != model.plot().data[0].y.tolist()
    page = tmp_path / "page.html"
    model.report(page, validate=other, diagnose=False)
    assert all(name in page.read_text(encoding="utf-8") for name in (train.path.name, other.path.name, other.digest))
    with pytest.raises(ident.BadInput, match=r"a new name expected, .*page\.html exists; .* force=True"):
        model.report(page, diagnose=False)
    model.save(tmp_path / "loaded.json")
    loaded = ident.load_model(tmp_path / "loaded.json")
    for call in (loaded.plot, lambda: loaded.report(tmp_path / "other.html")):
        with pytest.raises(ident.BadInput, match="on: a recording expected, none found, as the model was loaded"):
            call()


def test_a_report_is_the_page_of_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for shape, name in enumerate(("a", "b")):
        measured(shape).to_frame().to_csv(f"{name}.csv", index=False)
        import_data(Path(f"{name}.csv"), Path(f"{name}.mcap"), Description(rig=bench()))
    ident.fit("a.mcap", validate="b.mcap", method="ls").save("model.json")
    ident.load_model("model.json").report("python.html", "a.mcap", validate="b.mcap", diagnose=False)
    ran(program, "report", "model.json", "a.mcap", "--validate", "b.mcap", "--no-diagnose", "-o", "command.html")
    assert Path("python.html").read_bytes() == Path("command.html").read_bytes()


def test_objects_show_a_line_and_a_table_without_markup_of_others(model: Model, train: Recording) -> None:
    odd = ident.Recording.from_frame(
        train.to_frame().rename(columns={"cycle": "<b>"}), rig=train.rig.model_copy(update={"name": "<i>"})
    )
    for shown in (model, ident.compare(model, train), ident.check(train), odd):
        assert len(str(shown)) < 150
        assert "\n" not in repr(shown)
        assert shown._repr_html_().startswith("<table>")
    assert "<i>" not in odd._repr_html_()
    assert "&lt;b&gt;" in odd._repr_html_()


def test_a_frame_without_pandas_says_how_to_get_it(model: Model, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ident.BadInput, match="pip install"):
        model.to_frame()


@pytest.mark.slow
def test_models_and_ten_recordings_work_in_other_processes(model: Model) -> None:
    recordings, fit = [measured(shape) for shape in range(10)], partial(ident.fit, method="ls")
    motion = [np.linspace(-1, 1, 20)[:, None]] * 3
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        models = [model, *pool.map(fit, recordings)]
        found = list(pool.map(methodcaller("torque", *motion), models))
    np.testing.assert_array_equal(found, [each.torque(*motion) for each in models])
    assert [each.parameters for each in models[1:]] == [fit(each).parameters for each in recordings]


@pytest.mark.usefixtures("no_collection")
def test_an_interrupt_ends_a_call_and_the_next_one_works(train: Recording, other: Recording, model: Model) -> None:
    main = threading.get_ident()

    def interrupted(*_: object) -> None:
        """As Ctrl-C, or the button of a notebook, at this moment."""
        signal.pthread_kill(main, signal.SIGINT)

    calls: tuple[Callable[[], object], ...] = (
        lambda: ident.fit(train, method="pso", progress=interrupted),
        lambda: ident.diagnose(train, validate=other, progress=interrupted),
        lambda: ident.check(train, progress=interrupted),
    )
    for call in calls:
        with pytest.raises(KeyboardInterrupt):
            call()
    again = ident.fit(train, validate=other, method="ls", effects=["quadratic_friction"])
    assert again.parameters == model.parameters


@pytest.mark.slow
def test_every_call_of_the_contract(
    train: Recording, other: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, made in (("a", train), ("b", other)):
        made.to_frame().to_csv(f"{name}.csv", index=False)
        import_data(Path(f"{name}.csv"), Path(f"{name}.mcap"), Description(rig=made.rig))
    recording = ident.read("a.mcap")
    recording.to_frame().rename(columns={"effort_1": "i1"}).to_csv("a.csv", index=False)
    assert ident.read("a.csv", map={"effort_1": "i1:A*0.12"}, rig=train.rig).effort is not None
    time, position, more = np.arange(9.0), np.sin(np.arange(27.0)).reshape(9, 3), np.ones((9, 3))
    told = {"velocity": more, "command": position, "temperature": more, "cycle": np.zeros(9, int), "rig": None}
    for torque in ("effort", "voltage"):
        assert ident.Recording.from_arrays(time, position, **{torque: more}, **told).rig.dof == 3
    motor = train.rig.model_copy(update={"torque": measured_torque(1, (0.12,))})
    driven = ident.Recording.from_arrays(time, position[:, 0], current=more[:, 0], rig=motor)
    assert driven.effort == pytest.approx(0.12)

    short = {"particles": 80, "iterations": 20}
    model = ident.fit("a.mcap", validate="b.mcap", method="pso", effects=["stribeck"], settings=short)
    model.save("m.json")
    model = ident.load_model("m.json")
    for each in model.parameters.values():
        assert (float(each), bool(each.unit), each.ci95 is None) == (each.value, True, each.std is None)
    assert len(model.to_frame()) == len(model.parameters) == len(model.covariance)
    assert model.export("c", "controller/", on="a.mcap").carried == ("stribeck",)
    residuals = ident.compare(model, "b.mcap")
    assert set(residuals.as_json()) >= {"recordings", "data_problems"}
    assert ident.check(recording).effects

    diagnosis = ident.diagnose("a.mcap", validate="b.mcap")
    assert diagnosis.verdict == "missing-effect"
    assert all(figure.data for figure in (diagnosis.plot(), residuals.plot()))
    assert diagnosis.propose("law.py") is None
    assert diagnosis.model.export("c", "diagnosed/").carried == diagnosis.model.effects

    q = qd = qdd = np.full((4, 1), 0.3)
    torque = diagnosis.model.torque(q, qd, qdd, dt=0.01, t=np.arange(4.0), temperature=q)
    np.testing.assert_allclose(sum(diagnosis.model.terms(q, qd, qdd, dt=0.01).values()), torque)
    np.testing.assert_allclose(diagnosis.model.acceleration(q, qd, torque), qdd)
    assert diagnosis.model.voltage(q, qd, qdd).shape == q.shape
    assert diagnosis.model.inertia(q).shape == (4, 1, 1)


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
