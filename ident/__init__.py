"""Identify the dynamic model of a recorded robot, and find the physical effect that it lacks: the Python API.

    model = ident.fit("a.mcap", validate="b.mcap")
    diagnosis = ident.diagnose("a.mcap", validate="b.mcap")

The commands of `ident` call these functions. Importing this package is fast: the modules behind it are loaded when
they are needed. Arrays are (n, dof), in SI units. docs/reference/python.md shows a session.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ident.basics.arguments import names, paths, sources
from recordings.errors import BadInput, RunFailed, expect
from recordings.notebook import cell_progress

if TYPE_CHECKING:
    from ident.diagnosis.diagnosis import StatusCallback
    from ident.diagnosis.document.result import DiagnosisResult
    from ident.diagnosis.visibility.check import CheckDocument
    from ident.estimation.problem import Progress
    from ident.identification.model import Model
    from ident.residuals.analysis import ResidualAnalysis
    from ident.uncertainty.covariance import IntervalMethod
    from recordings.recording import Recording
    from recordings.rig import Rig

__all__ = [
    "BadInput",
    "Model",
    "Recording",
    "RunFailed",
    "__version__",
    "check",
    "compare",
    "diagnose",
    "fit",
    "load_model",
    "read",
]

File = str | Path
_CLASSES = {"Model": "ident.identification.model", "Recording": "recordings.recording"}


def __dir__() -> list[str]:
    """The interface, without modules and what they import."""
    return __all__


def __getattr__(name: str) -> Any:
    """Load `Model`, `Recording` and `__version__` when they are asked for."""
    if name == "__version__":
        from importlib.metadata import version

        return version("delta-workbench")
    if name not in _CLASSES:
        raise AttributeError(f"module 'ident' has no attribute '{name}'")
    return getattr(import_module(_CLASSES[name]), name)


def read(path: File, *, map: Mapping[str, str] | None = None, rig: File | Rig | None = None) -> Recording:
    """Read the recording `path` (.mcap), or measurements in any format that `daq import` reads, such as CSV.

    map: column and unit of a quantity, as {"effort_1": "i1:A*0.12"}, where a column has another name or unit.
    rig: description of the machine or its file, of measurements of another program; None: the delta robot.

    Raises:
        BadInput: the file is missing, cannot be read, or does not hold what a recording needs.
    """
    from recordings import reader
    from recordings.importing import in_memory, is_ours

    expect(str | Path, "a path", path=path)
    if map is None and rig is None and is_ours(Path(path)):
        return reader.read(Path(path))
    return in_memory.of_file(Path(path), map, rig)


def fit(
    files: File | Recording | Sequence[File | Recording],
    *,
    validate: File | Recording | Sequence[File | Recording] | None = None,
    method: str | None = None,
    effects: str | Sequence[str] = (),
    without: str | Sequence[str] = (),
    bare: bool = False,
    effect_files: File | Sequence[File] = (),
    preprocessing: str = "parallel",
    cutoff: float | None = None,
    physical: bool = False,
    intervals: IntervalMethod = "stationary",
    seed: int = 0,
    settings: Mapping[str, Any] | None = None,
    accept: str | Sequence[str] = (),
    progress: Progress | None = None,
) -> Model:
    """Fit the dynamic model, Eq. (26), to the recordings `files` of one rig together.

    validate: recordings that the fit does not use, on which the model is judged.
    method: estimator (`ident fit --help`), with its `settings` by name (`ident methods`); None: the paper's swarm,
        or, for the tens of parameters of a URDF, weighted least squares.
    effects: added to the base model, each as NAME, on all joints, or as NAME:1,3.
    without: effects of the base model to leave out; bare: all of them are, as in the paper.
    effect_files: Python files with effects of your own; they are executed.
    preprocessing, cutoff: method and low-pass [Hz]; None: the cut-off is chosen from the spectra.
    physical: allow only friction that opposes motion (search methods).
    accept: kinds of data problems in spite of which the recordings are used.
    progress: function that is told how many steps of how many are done; None: a notebook shows them.

    Raises:
        ImplausibleData: a recording cannot be what it is said to be.
        BadInput: a recording cannot be used, the recordings are not of one rig, or an option does not exist.
        TypeError: an argument has another type; it is named.
    """
    from ident.diagnosis.unknown.residual_test import fit_and_test
    from ident.dynamics.effects.library import library
    from ident.estimation import estimators
    from ident.identification.identify import FitOptions

    expect(str | None, "a name", method=method)
    expect(bool, "True or False", bare=bare)
    expect(Mapping | None, "a mapping of settings by name", settings=settings)
    options = FitOptions(
        method=method or "pso",
        settings=estimators.settings(method or "pso", settings or {}),
        seed=seed,
        preprocessing=preprocessing,
        cutoff=cutoff,
        effects=names(effects, "effects"),
        base_effects=not bare,
        without=names(without, "without"),
        library=library(paths(effect_files, "effect_files")),
        physical=physical,
        intervals=intervals,
        accept=names(accept, "accept"),
        by_default=method is None and not settings,
    )
    with cell_progress() as show:
        steps = progress or (lambda done, total, *_: show("fitting", done, total))
        return fit_and_test(sources(files, "files", least=1), sources(validate, "validate"), options, steps)


def load_model(path: File, *, effect_files: File | Sequence[File] = ()) -> Model:
    """Load a model file. `effect_files`: Python files with effects of your own that the model has; they are executed.

    Raises:
        BadInput: the file is missing, is not a model, or an effect file cannot be used.
        TypeError: an argument has another type; it is named.
    """
    from ident.dynamics.effects.library import library
    from ident.identification import model_file
    from ident.identification.model import Model

    expect(str | Path, "a path", path=path)
    return Model(model_file.load(Path(path)), library(paths(effect_files, "effect_files")))


def compare(
    model: Model, files: File | Recording | Sequence[File | Recording], *, accept: str | Sequence[str] = ()
) -> ResidualAnalysis:
    """Compare `model` with the recordings `files`: the residual by joint, phase, window, quantity and frequency.

    accept: as in `fit`, beside what the model was fitted with.

    Raises:
        ImplausibleData: a recording cannot be what it is said to be.
        BadInput: a recording cannot be used, or is of another rig than the model.
        TypeError: an argument has another type; it is named.
    """
    from ident.diagnosis.unknown.residual_test import scored_predictions
    from ident.identification.model import Model
    from ident.identification.prediction import predict
    from ident.residuals.analysis import analyse

    expect(Model, "a model of ident.fit or ident.load_model", model=model)
    predictions = predict(model.file, sources(files, "files", least=1), model.library, names(accept, "accept"))
    return analyse(model.file, *scored_predictions(model.file, predictions, model.library))


def diagnose(
    files: File | Recording | Sequence[File | Recording],
    *,
    validate: File | Recording | Sequence[File | Recording] | None = None,
    model: Model | None = None,
    effect_files: File | Sequence[File] = (),
    preprocessing: str = "parallel",
    cutoff: float | None = None,
    only: str | Sequence[str] = (),
    without: str | Sequence[str] = (),
    accept: str | Sequence[str] = (),
    progress: StatusCallback | None = None,
) -> DiagnosisResult:
    """Find the physical effects that the model of the recordings `files` lacks, with the evidence.

    validate: recordings of other motions that no fit sees; without any, phase segments are held out.
    model: the model whose effects are the start; None: the base model.
    effect_files: Python files with effects of your own; they are executed. Without any: those of `model`.
    preprocessing, cutoff: as in `fit`.
    only: effects to add in this order, without any others.
    without: effects of the library to leave out.
    accept: as in `fit`.
    progress: function that is told the current activity; None: a notebook shows it.

    Raises:
        ImplausibleData: a recording cannot be what it is said to be.
        BadInput: a recording cannot be used, the recordings are not of one rig, or an effect does not exist.
        TypeError: an argument has another type; it is named.
    """
    from ident.diagnosis.diagnosis import DiagnosisOptions
    from ident.diagnosis.document.result import diagnosed
    from ident.dynamics.effects.library import library
    from ident.identification.model import Model

    expect(Model | None, "a model of ident.fit or ident.load_model", model=model)
    expect(Callable | None, "a function", progress=progress)  # type: ignore[arg-type]
    train, held_out = sources(files, "files", least=1), sources(validate, "validate")
    chosen = names(only, "only"), names(without, "without"), names(accept, "accept")
    options = DiagnosisOptions(preprocessing, cutoff, *chosen)
    # A file of the user is executed once: what the model was loaded with is there already.
    effects = model.library if model and not effect_files else library(paths(effect_files, "effect_files"))
    with cell_progress() as show:
        return diagnosed(train, held_out, effects, options, progress or show, model.file if model else None)


def check(
    files: File | Recording | Sequence[File | Recording],
    *,
    share: float = 0.03,
    effect_files: File | Sequence[File] = (),
    accept: str | Sequence[str] = (),
    progress: StatusCallback | None = None,
) -> CheckDocument:
    """Tell what the recordings `files` can show: of which effects, from which size on, and what is wrong with them.

    share: size of the effects, as RMS of their torque relative to that of the joint: above 0, at most 1.
    effect_files, accept: as in `fit`; progress: as in `diagnose`.

    Raises:
        ImplausibleData: a recording cannot be what it is said to be.
        BadInput: a recording cannot be used, or they are not of one rig.
        TypeError: an argument has another type; it is named.
    """
    from ident.diagnosis.visibility.check import check
    from ident.dynamics.effects.library import library

    expect(Real, "a number", share=share)
    if not 0 < share <= 1:
        raise BadInput(f"share: more than 0 and at most 1 expected, {share} found; 0.03 is 3 % of the torque")
    expect(Callable | None, "a function", progress=progress)  # type: ignore[arg-type]
    effects, seen = library(paths(effect_files, "effect_files")), sources(files, "files", least=1)
    with cell_progress() as show:
        return check(seen, effects, share, progress or show, names(accept, "accept"))
