"""Small whole files of every kind that a command reads, and the calls that read them."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np
import pyarrow
from pyarrow import parquet
from scipy.io import savemat

from daq.feedforward.torque_table import read_torque_table
from daq.program import program as daq
from drivers.eds import load_dictionary
from drivers.simulated.config import ROBOTS, SimConfig, load_sim
from drivers.simulated.seal import seal, sealed_path, unseal
from ident import load_model
from ident.dynamics.effects.user_files import from_file
from ident.fleet.store import SCHEMA, Store
from ident.program import program as ident
from recordings.importing import Description, formats, import_data
from recordings.importing.mapping import sources
from recordings.reader import read
from recordings.recording import Recording
from recordings.rig import load_rig, simulated_rig
from tests.ident.kept_models import MODELS
from tests.made_up import run_of
from tests.recordings.conftest import make_samples, write_samples
from tests.recordings.importing import foreign

Call = Callable[[Path], object]
"""Reads a file as a command does; raises BadInput for one that cannot be read."""
ROOT = Path(__file__).parents[2]
SCOPE = ROOT / "recordings/samples/foreign/scope-fig5b.csv"
RECORDING = MODELS / "fig5b.mcap"
_ROWS = 600
"""Rows of tables."""
_SCOPE_VIEW = "Name\tq1\nFile\tscope.svd\nStarttime of export\t134000000000000000\n\nName\tq1\nUnit\tdeg\n"


class Kind(NamedTuple):
    """Files of one kind; a damaged one is read in one of the ways of `calls`."""

    original: Path
    calls: tuple[Call, ...]


def _command(program: Any, words: str) -> Call:
    """A command as a call: FILE is the file, OUT a new one beside it."""

    def call(path: Path) -> None:
        names = {"FILE": path, "RECORDING": RECORDING, "SCOPE": SCOPE}
        arguments = [str(names.get(word, word.replace("OUT", f"{path.parent}/out"))) for word in words.split()]
        program(arguments, standalone_mode=False)

    return call


_RECORDING = tuple(
    _command(program, words)
    for program, words in (
        (daq, "info FILE"),
        (daq, "recover FILE --out OUT.mcap"),
        (daq, "export FILE --to csv --out OUT.csv"),
        (daq, "export FILE --to candump --out OUT.log"),
        (ident, "check FILE"),
        (ident, "fit FILE --method ls -o OUT.model.json"),
    )
)
_MODEL: tuple[Call, ...] = (
    load_model,
    *(
        _command(ident, words)
        for words in (
            "compare FILE RECORDING --json",
            "torque FILE RECORDING",
            "torque FILE --traj fig5a --cycles 1 -o OUT.csv",
            "export FILE --to c -o OUT --on RECORDING",
            "export FILE --to mjcf -o OUT.xml --on RECORDING",
            "report FILE RECORDING -o OUT.html",
            "diagnose RECORDING --model FILE --only stribeck --json",
        )
    ),
)


def _import(path: Path) -> None:
    """As `daq import`, which would also start `ident check`."""
    import_data(path, path.parent / "out.mcap", Description())


_FOREIGN = (_import, _command(daq, "import FILE --guess"))


def _read_store(path: Path) -> None:
    """As `ident fleet` reads the tables of its store."""
    (path.parent / "store/recordings").mkdir(parents=True)
    shutil.copy(path, path.parent / "store/recordings/one-.parquet")
    Store(path.parent / "store").table()


def _read_mapping(path: Path) -> None:
    sources(formats.read(SCOPE), [str(path)])


def kinds(folder: Path) -> dict[str, Kind]:
    """Write an original of every kind to `folder`."""
    recording, effect = read(RECORDING), ROOT / "docs/examples/tight_spot.py"
    small = folder / "small.mcap"
    write_samples(small, simulated_rig(), run_of(), make_samples(21))
    made = {path: calls for files in (_texts(folder), _tables(folder, recording)) for path, calls in files.items()}
    models = dict.fromkeys(sorted(MODELS.glob("*.model.json")), _MODEL)
    shipped = {
        RECORDING: _RECORDING,
        small: _RECORDING,
        ROOT / "recordings/samples/foreign/scope.toml": (_read_mapping,),
        ROBOTS / "heavy.toml": (load_sim,),
        ROOT / "drivers/simulated/drive.eds": (
            lambda path: load_dictionary(path, 1),
            _command(daq, "rig propose --eds FILE --out OUT.toml"),
        ),
        effect: (from_file, _command(ident, "effects --effect-file FILE")),
    }
    return {path.name: Kind(path, calls) for path, calls in (models | shipped | made).items()}


def _texts(folder: Path) -> dict[Path, tuple[Call, ...]]:
    """Descriptions, in text."""
    rig, drives = folder / "rig.toml", "".join(f"[[drives]]\nnode_id = {i}\nsign = -1\n" for i in (1, 2, 3))
    rig.write_text(f'name = "r"\n[limits]\nspeed = 9.5\n[torque]\ngain = [1.0, 2, 3]\n{drives}')
    fourier = folder / "motion.toml"
    waves = "[[0.1], [0.1], [0.1]]"
    fourier.write_text(
        'kind = "fourier"\nspace = "joint"\nperiod = 2.0\ncentre = [0.1, 0.2, 0.3]\n'
        f"cosine = {waves}\nsine = {waves}\n"
    )
    plant = SimConfig().model_dump(mode="json")
    seal(sealed_path(folder / "small.mcap"), {"seed": 1, "effects": [], "plant": plant})
    diagnosis = folder / "diagnosis.json"
    step = {"parameters": {"m_p": {"value": 1.0}}}
    finding = {"effect": "stribeck", "joints": [1], "confusable_with": []}
    diagnosis.write_text(json.dumps({"findings": [finding], "steps": [step]}))
    reveal = _command(daq, f"reveal {folder}/small.mcap FILE")
    trajectory = _command(daq, "trajectories FILE --cycles 1")
    return {
        rig: (load_rig, _command(daq, "import SCOPE --guess --rig FILE")),
        fourier: (trajectory,),
        sealed_path(folder / "small.mcap"): (unseal, _command(daq, "reveal FILE")),
        diagnosis: (reveal,),
    }


def _tables(folder: Path, recording: Recording) -> dict[Path, tuple[Call, ...]]:
    """Measurements and motions, in text and binary formats."""
    numbers = range(1, 4)
    time = {"time": recording.time[:_ROWS]}
    moving = time | {f"position_{k}": recording.position[:_ROWS, k - 1] for k in numbers}
    efforts = foreign.torque(recording)[:_ROWS]
    measured = moving | {f"effort_{k}": efforts[:, k - 1] for k in numbers}
    np.savez_compressed(folder / "log.npz", **measured)  # type: ignore[arg-type]
    savemat(folder / "log.mat", measured, do_compression=True)
    parquet.write_table(pyarrow.table(measured), folder / "log.parquet")
    with h5py.File(folder / "log73.mat", "w", userblock_size=512) as file:
        for name, values in measured.items():
            file.create_dataset(name, data=values[:, None], compression="gzip")
    with (folder / "log73.mat").open("r+b") as stream:
        stream.write(b"MATLAB 7.3 MAT-file")
    view = folder / "view.csv"
    view.write_text(_SCOPE_VIEW + "\n".join(f"{k}\t{x:.6g}" for k, x in enumerate(recording.position[:_ROWS, 0])))
    store = folder / "store.parquet"
    parquet.write_table(SCHEMA.empty_table(), store)
    course = np.sin(time["time"]) / 20
    points = _csv(folder / "points.csv", time | {"x": course, "y": course, "z": course - 0.7})
    path, sent = _csv(folder / "path.csv", moving), moving | {f"torque_{k}": efforts[:, k - 1] for k in numbers}
    follow = _command(ident, f"torque {MODELS}/stribeck.model.json --csv FILE")
    return {
        _csv(folder / "log.csv", measured): _FOREIGN,
        view: _FOREIGN[1:],
        folder / "log.npz": _FOREIGN,
        folder / "log73.mat": _FOREIGN,
        folder / "log.mat": _FOREIGN,
        folder / "log.parquet": _FOREIGN,
        foreign.db3(recording, folder): _FOREIGN,
        foreign.mcap(recording, folder): _FOREIGN,
        store: (_read_store,),
        points: (_command(daq, "trajectories FILE"), follow),
        path: (follow,),
        _csv(folder / "torque.csv", sent): (lambda path: read_torque_table(path, simulated_rig()),),
    }


def _csv(path: Path, columns: dict[str, np.ndarray]) -> Path:
    np.savetxt(path, np.column_stack(list(columns.values())), "%.9g", ",", header=",".join(columns), comments="")
    return path
