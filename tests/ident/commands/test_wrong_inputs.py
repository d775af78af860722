"""What a user gets wrong: every command says what was expected and found, and writes nothing."""

import json
import re
import shlex
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import ident
from ident.identification.model import Model
from ident.program import program
from recordings.errors import BadInput, ForeignFile
from recordings.reader import read
from recordings.recording import Recording
from recordings.rig import Geometry, Rig, Torque, simulated_rig
from tests.ident.commands.test_axes import write as write_slide
from tests.ident.kept_models import MODELS
from tests.running import invoke, printed, ran

RIGS = {
    "length.toml": 'name = "other"\n[geometry]\nL2 = 0.81\n',
    "gain.toml": 'name = "other"\n[torque]\ngain = [1.0, 1.0, 1.1]\n',
    "axes.toml": 'name = "other"\nmechanism = "axes"\n[[axes]]\n[[axes]]\n[[axes]]\n',
}

WRONG = [
    ("fit none.mcap", "none.mcap does not exist"),
    ("fit a.mcap other.mcap", r"geometry.L2 is 0.8 in a.mcap, 0.81 in other.mcap"),
    ("fit a.mcap --validate other.mcap", "geometry.L2"),
    ("fit a.mcap gain.mcap", r"torque.gain is .* calibrate gains that are only assumed \(`ident calibrate-gain`\)"),
    ("fit a.mcap --validate again.mcap", "begin with the same data"),
    ("fit rest.mcap", "joint 2"),
    ("fit slide.mcap volts.mcap", "effort in slide.mcap, voltage in volts.mcap"),
    ("fit slide.mcap --method rls", "delta"),
    ("fit a.mcap -o a.txt", r"a model's name \(.model.json\) expected, a.txt found"),
    ("fit a.mcap --with cogging:", "joint"),
    ("fit a.mcap --without stribeck", r"an effect of the base model \(rod_inertia\) expected, 'stribeck' found"),
    ("fit a.mcap --cutoff 400", "a fifth of the rate"),
    ("fit a.mcap --cutoff 20 --preprocess central", "no cut-off"),
    ("fit a.mcap --paper --preprocess parallel", "--preprocess cannot be combined with --paper, .* 'parallel' found"),
    ("fit a.mcap --set partcles=9", r"'partcles' found; did you mean particles\?"),
    ("fit a.mcap --set particles=few", "particles: an integer from 2 to 100000 expected, 'few' found"),
    ("fit a.mcap --method svd --set iterations=2", "a setting of threshold expected, 'iterations' found"),
    ("fit a.mcap --method pso_nonlinear", "such as --with stribeck, expected, none found"),
    ("methods psoo", "did you mean pso?"),
    ("compare later.json a.mcap", "schema 2 expected, 99 found; update this software"),
    ("compare list.json a.mcap --report page.html", "model file list.json: a JSON object expected"),
    ("compare broken.json a.mcap", "model file broken.json is not valid JSON"),
    ("compare terms.json a.mcap", r"effects \[.*\] expected, those of its terms, \[foo, rod_inertia\] found"),
    ("compare m.json a.mcap --report a.mcap --force", "one of the inputs"),
    ("compare m.json a.mcap --report m.json --force", "one of the inputs"),
    ("diagnose a.mcap --out better.json", "--apply expected"),
    ("diagnose a.mcap --model none.json", "does not exist"),
    ("diagnose a.mcap --effect-file none.py", "Python file"),
    ("report m.json -o r.html", "no recording"),
    ("report a.mcap -o r.html", "no model"),
    ("report m.json a.mcap notes.txt -o r.html", "notes.txt does not exist"),
    ("report m.json a.mcap --validate a.mcap -o r.html", "twice"),
    ("report m.json a.mcap -o m.json --force", "replaced"),
    ("report m.json a.mcap -o no/r.html --no-diagnose", "does not exist"),
    ("report m.json a.mcap --response b.mcap --no-diagnose", "motion of one joint"),
    ("check no.mcap", "no.mcap does not exist"),
    ("check a.mcap --share 3", "--share"),
    ("design -o best.csv", "ends in .toml"),
    ("design --period nan -o best.toml", "'--period': a number from 0.5 up to 60 expected, 'nan' found"),
    ("design --joint 2 -o best.toml", "--discriminate expected"),
    ("design --criterion d --discriminate stribeck backlash -o best.toml", "--criterion"),
    ("design --discriminate stribeck -o next.toml", "names of two effects expected"),
    ("calibrate-gain a.mcap none.mcap --payload 1", "none.mcap does not exist"),
    ("export m.json --to simulink -o a", "one of c, csv, fmu, mcap, mjcf, urdf expected, 'simulink' found"),
    ("export m.json --to c -o a --traj fig5a --on b.mcap", "one of --traj, --csv and --on expected"),
    ("export m.json --to c -o no/such/folder", "folder no/such does not exist"),
    ("export m.json --to fmu -o a.fmu --precision float", "double precision"),
    ("export slide.json --to c -o slide", "is not at hand; give another one"),
    ("torque m.json", "one of --traj, --csv and a recording expected"),
    ("torque m.json --traj fig5b b.mcap", "one of --traj, --csv and a recording expected"),
    ("torque m.json --traj fig5c", "unknown trajectory 'fig5c'"),
    ("torque m.json --csv nothing.csv", "nothing.csv does not exist"),
    ("torque m.json b.mcap --cycles 2", "--cycles and --rate belong to --traj"),
    ("torque m.json b.mcap --temperature 20", "--temperature belongs to a path that is given"),
    ("torque m.json --traj fig5b -o a.xlsx", "an ending of .csv"),
    ("torque m.json --traj fig5b -o a.csv --to xlsx", "one of csv, json, parquet expected, 'xlsx' found"),
    ("torque m.json --traj fig5b --rig length.toml", "geometry.L2 is 0.8 in the model, 0.81 in"),
    ("torque m.json --traj fig5b --rig gain.toml", "torque.gain is"),
    ("torque m.json --traj fig5b --rig axes.toml", "mechanism is delta in the model"),
    ("table2 --sizes many --plots p", "numbers of particles such as 50,100,300 expected, 'many' found"),
    ("table2 --sizes 100,2 --plots p", "each of 3 or more, expected, '100,2' found"),
    ("table2 --set threshold=0.3 --plots p", "METHOD.NAME=VALUE .* 'threshold' found"),
    ("table2 --set svt.threshold=0.3 --plots p", "did you mean svd"),
    ("table2 --set svd.treshold=0.3 --plots p", "did you mean threshold"),
    ("table2 a.mcap", "1 found"),
    ("table2 slide.mcap slide.mcap --plots p", "a delta robot expected, axes found"),
    ("table2 a.mcap b.mcap other.mcap", "3 found"),
    ("watch m.json none.mcap --healthy a.mcap", "none.mcap does not exist"),
    ("watch slide.json slide.mcap", "the model was validated with none; give them by --healthy"),
    ("workbench nowhere --no-browser", r"a folder, or existing recordings \(.mcap\), expected, nowhere found"),
    ("workbench fleet --no-browser", "a store of `ident fleet` found; say, ident workbench --store fleet"),
    ("fleet fleet --store fleet", "`ident fleet report --store fleet -o fleet.html` shows it"),
    ("fleet none --store store", "a folder of recordings expected"),
    ("fleet . --store store --engine serial --scheduler tcp://x:1", "--engine dask expected"),
    ("fleet . --store store --scheduler host", "an address as tcp://host:8786 expected"),
    ("fleet . --store store --scheduler-file none.json", "a Dask scheduler wrote expected"),
    ("fleet .", "--store DIR expected, the folder of the results, none found; say, ident fleet recordings --store"),
    ("fleet report", "none found; say, ident fleet report --store fleet -o fleet.html"),
    ("fleet ack r1", "none found; say, ident fleet ack r07-20260314 --store fleet"),
    ("fleet report --store none -o x.html", "a store of `ident fleet` expected"),
    ("fleet ack r1 --store none", "a store of `ident fleet` expected"),
]

KEPT = [
    ("fit a.mcap -o mine.json", "mine.json"),
    ("compare m.json a.mcap --report page.html", "page.html"),
    ("diagnose a.mcap --report page.html", "page.html"),
    ("report m.json a.mcap --no-diagnose -o page.html", "page.html"),
    ("design -o best.toml", "best.toml"),
    ("calibrate-gain a.mcap b.mcap --payload 1 -o torque.toml", "torque.toml"),
    ("export m.json --to mjcf -o robot.xml", "robot.xml.carried.json"),
    ("torque m.json --traj fig5b -o a.csv", "a.csv"),
    ("table2 --plots plots", "plots"),
]


@pytest.fixture(scope="module")
def folder(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """A folder with recordings, models and rig files that fit together, and others that do not."""
    folder = tmp_path_factory.mktemp("wrong")
    for name, kept in {"a.mcap": "fig5a.mcap", "b.mcap": "fig5b.mcap", "m.json": "stribeck.model.json"}.items():
        shutil.copy(MODELS / kept, folder / name)
    shutil.copy(MODELS / "slide.model.json", folder / "slide.json")
    whole = read(folder / "a.mcap")
    write(replace(whole, path=folder / "again.mcap", run=whole.run.model_copy(update={"trajectory": "again"})))
    rig = simulated_rig().model_copy(update={"geometry": Geometry(L2=0.81)})
    write(make("fig5a", cycles=1, rig=rig, path=folder / "other.mcap"))
    write(make("fig5b", rig=Rig(name="other", torque=Torque(gain=(1.0, 1.0, 1.1))), path=folder / "gain.mcap"))
    resting = make(cycles=1, path=folder / "rest.mcap")
    resting.position[:, 1] = 0.2
    write(resting)
    write_slide(folder / "slide.mcap", 0)
    write_slide(folder / "volts.mcap", 2, voltage=True)
    (folder / "fleet" / "recordings").mkdir(parents=True)
    (folder / "fleet" / "recordings" / "one-x.parquet").touch()
    for name, text in RIGS.items():
        (folder / name).write_text(text)
    terms = json.loads((folder / "m.json").read_text()) | {"effects": ["foo", "rod_inertia"]}
    odd = {"later.json": '{"schema": 99}', "list.json": "[]", "broken.json": "{", "terms.json": json.dumps(terms)}
    for name, text in odd.items():
        (folder / name).write_text(text)
    return folder


@pytest.mark.parametrize(("line", "message"), WRONG)
def test_wrong_input_is_explained_and_leaves_nothing(
    line: str, message: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)

    def files() -> dict[Path, int]:
        return {path: path.stat().st_mtime_ns for path in folder.rglob("*") if "store" not in path.parts}

    before = files()
    with pytest.raises(BadInput) as refused:
        printed(program, *shlex.split(line))
    assert re.search(message, " ".join(str(refused.value).split()))
    assert files() == before


@pytest.mark.parametrize(("line", "out"), KEPT)
def test_what_exists_is_kept_unless_forced(
    line: str, out: str, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("a.mcap", "b.mcap", "m.json"):
        (tmp_path / name).symlink_to(folder / name)
    (tmp_path / out).write_text("mine")
    with pytest.raises(BadInput, match=rf"a new name expected, {out} exists; .* --force"):
        printed(program, *shlex.split(line))
    assert (tmp_path / out).read_text() == "mine"
    assert len(list(tmp_path.iterdir())) == 4


@pytest.mark.parametrize(
    ("line", "default", "numbered"),
    [
        ("fit a.mcap --method ls", "a.model.json", "a-2.model.json"),
        ("compare m.json a.mcap", "a.m.compare.html", "a.m.compare-2.html"),
        ("report m.json a.mcap --no-diagnose", "a.report.html", "a.report-2.html"),
        ("design --harmonics 1", "design.toml", "design-2.toml"),
    ],
)
def test_results_without_a_name_get_one_that_is_free(
    line: str, default: str, numbered: str, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("a.mcap", "m.json"):
        (tmp_path / name).symlink_to(folder / name)
    (tmp_path / default).write_text("mine")
    assert numbered in ran(program, *shlex.split(line)).stderr
    assert (tmp_path / default).read_text() == "mine"
    assert (tmp_path / numbered).stat().st_size > len("mine")
    ran(program, *shlex.split(line), "--force")
    assert (tmp_path / default).stat().st_size > len("mine")


def test_a_name_that_another_run_takes_meanwhile_is_not_replaced(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.mcap").symlink_to(folder / "a.mcap")
    fit = ident.fit

    def beside_another(*given: Any, **options: Any) -> Model:
        Path("a.model.json").write_text("the other's")
        return fit(*given, **options)

    monkeypatch.setattr(ident, "fit", beside_another)
    assert "model: a-2.model.json" in ran(program, "fit", "a.mcap", "--method", "ls").stderr
    assert Path("a.model.json").read_text() == "the other's"


@pytest.mark.parametrize(
    ("line", "unknown"),
    [
        ("diagnose a.mcap --report there --only cogg", "cogg"),
        ("diagnose a.mcap --report there --accept torque", "torque"),
        ("fit a.mcap -o there --with cogg:1", "cogg"),
        ("fit a.mcap -o there --set partcles=9", "partcles"),
        ("report m.json a.mcap -o there --accept torque", "torque"),
        ("torque m.json --traj fig5z -o there --to csv", "fig5z"),
        ("export m.json --to mjcf -o there --traj fig5z", "fig5z"),
        ("table2 --plots there --set pso.partcles", "pso.partcles"),
    ],
)
def test_other_wrong_arguments_are_told_before_an_output_that_exists(
    line: str, unknown: str, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("a.mcap", "m.json"):
        (tmp_path / name).symlink_to(folder / name)
    (tmp_path / "there").write_text("mine")
    with pytest.raises(BadInput, match=f"'{unknown}'|{unknown} "):
        printed(program, *shlex.split(line))


@pytest.mark.parametrize("name", ["log.csv", "log.npz", "bag"])
def test_a_file_of_another_program_is_known_as_such(name: str, folder: Path, tmp_path: Path) -> None:
    foreign = tmp_path / name
    foreign.write_text("t;q1\n") if foreign.suffix else foreign.mkdir()
    error = invoke(program, "report", folder / "m.json", foreign).exception
    assert isinstance(error, ForeignFile), "`ident` then says the command that reads it"
    assert error.path == foreign
    assert "model (.json)" in str(error)
