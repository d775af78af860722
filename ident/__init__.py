"""Identify the dynamic model of a recorded robot, and find the physical effect that it lacks: the Python API.

    model = ident.fit("a.mcap", validate="b.mcap")
    diagnosis = ident.diagnose("a.mcap", validate="b.mcap")

The commands of `ident` call these functions. Importing this package is fast: the modules behind it are loaded when
they are needed. Arrays are (n, dof), in SI units. docs/reference/python.md shows a session.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

from recordings.errors import BadInput, RunFailed

if TYPE_CHECKING:
    from ident.diagnosis.diagnosis import StatusCallback
    from ident.diagnosis.document.result import DiagnosisResult
    from ident.estimation.problem import Progress
    from ident.identification.model import Model
    from ident.residuals.analysis import ResidualAnalysis
    from ident.uncertainty.covariance import IntervalMethod
    from recordings.recording import Recording

__all__ = ["BadInput", "Model", "RunFailed", "compare", "diagnose", "fit", "load_model", "read"]

File = str | Path


def __getattr__(name: str) -> Any:
    """Load `Model` when it is asked for."""
    if name == "Model":
        from ident.identification.model import Model

        return Model
    raise AttributeError(f"module 'ident' has no attribute '{name}'")


def read(path: File) -> Recording:
    """Read the recording `path` (.mcap): rig, run, and the measured signals (n, dof).

    Raises:
        BadInput: the file is missing or is not a recording.
    """
    from recordings import reader

    return reader.read(Path(path))


def fit(
    files: File | Sequence[File],
    validate: File | Sequence[File] | None = None,
    method: str = "pso",
    effects: str | Sequence[str] = (),
    *,
    without: Sequence[str] = (),
    bare: bool = False,
    effect_files: Sequence[File] = (),
    preprocessing: str = "parallel",
    cutoff: float | None = None,
    physical: bool = False,
    intervals: IntervalMethod = "stationary",
    seed: int = 0,
    settings: Mapping[str, Any] | None = None,
    accept: Sequence[str] = (),
    progress: Progress = lambda *_: None,
) -> Model:
    """Fit the dynamic model, Eq. (26), to the recordings `files` of one rig together.

    validate: recording that the fit does not use, on which the model is judged.
    method: estimator (`ident fit --help`), with its `settings` by name (`ident methods`).
    effects: added to the base model, each as NAME, on all joints, or as NAME:1,3.
    without: effects of the base model to leave out, which every real machine of this kind has (`rod_inertia`).
    bare: leave out all of them, as in the paper.
    effect_files: Python files with effects of your own; they are executed.
    preprocessing, cutoff: method and low-pass [Hz]; None: the cut-off is chosen from the spectra.
    physical: allow only friction that opposes motion (search methods).
    accept: kinds of data problems in spite of which the recordings are used.

    Raises:
        ImplausibleData: a recording cannot be what it is said to be.
        BadInput: a recording cannot be used, the recordings are not of one rig, or an option does not exist.
    """
    from ident.diagnosis.unknown.residual_test import check_residual
    from ident.dynamics.effects.library import library
    from ident.estimation import estimators
    from ident.identification.chosen_effects import check_effect_name
    from ident.identification.identify import FitOptions, identify
    from ident.identification.model import Model

    paths, held_out = _paths(files, "files", least=1), _paths(validate, "validate")
    if len(held_out) > 1:
        raise BadInput(f"validate: one recording expected, {len(held_out)} found; leave the others out")
    known = library(_paths(effect_files, "effect_files"))
    for name in _names(effects, "effects"):
        check_effect_name(name.partition(":")[0], known)
    options = FitOptions(
        method=method,
        settings=estimators.settings(method, settings or {}),
        seed=seed,
        preprocessing=preprocessing,
        cutoff=_cutoff(cutoff),
        effects=_names(effects, "effects"),
        base_effects=not bare,
        without=_names(without, "without"),
        library=known,
        physical=physical,
        intervals=intervals,
        accept=_names(accept, "accept"),
    )
    result = identify(paths, held_out[0] if held_out else None, options, progress)
    test = None if result.model.form else check_residual(result.predictions, result.structure, result.parameters)
    return Model(result.model.model_copy(update={"residual_test": test}), options.library, result)


def load_model(path: File, effect_files: Sequence[File] = ()) -> Model:
    """Load a model file. `effect_files`: Python files with effects of your own that the model has; they are executed.

    Raises:
        BadInput: the file is missing, is not a model, or an effect file cannot be used.
    """
    from ident.dynamics.effects.library import library
    from ident.identification import model_file
    from ident.identification.model import Model

    return Model(model_file.load(Path(path)), library(_paths(effect_files, "effect_files")))


def compare(model: Model, files: File | Sequence[File], *, accept: Sequence[str] = ()) -> ResidualAnalysis:
    """Compare `model` with the recordings `files`: the residual by joint, phase, window, quantity and frequency.

    accept: as in `fit`, beside what the model was fitted with.

    Raises:
        ImplausibleData: a recording cannot be what it is said to be.
        BadInput: a recording cannot be used, or is of another rig than the model.
    """
    from ident.diagnosis.unknown.residual_test import scored_predictions
    from ident.identification.prediction import predict
    from ident.residuals.analysis import analyse

    _check_model(model)
    predictions = predict(model.file, _paths(files, "files", least=1), model.library, _names(accept, "accept"))
    return analyse(model.file, *scored_predictions(model.file, predictions, model.library))


def diagnose(
    files: File | Sequence[File],
    validate: File | Sequence[File] | None = None,
    *,
    model: Model | None = None,
    effect_files: Sequence[File] = (),
    preprocessing: str = "parallel",
    cutoff: float | None = None,
    only: Sequence[str] = (),
    without: Sequence[str] = (),
    accept: Sequence[str] = (),
    progress: StatusCallback = lambda text: None,
) -> DiagnosisResult:
    """Find the physical effects that the model of the recordings `files` lacks, with the evidence.

    validate: recordings of other motions that no fit sees; without any, phase segments are held out.
    model: the model whose effects are the start; None: the base model.
    effect_files: Python files with effects of your own; they are executed. Without any: those of `model`.
    preprocessing, cutoff: as in `fit`.
    only: effects to add in this order, without any others.
    without: effects of the library to leave out.
    accept: as in `fit`.

    Raises:
        ImplausibleData: a recording cannot be what it is said to be.
        BadInput: a recording cannot be used, the recordings are not of one rig, or an effect does not exist.
    """
    from ident.diagnosis.diagnosis import DiagnosisOptions
    from ident.diagnosis.document.result import diagnosed
    from ident.dynamics.effects.library import library

    if model is not None:
        _check_model(model)
    paths, held_out = _paths(files, "files", least=1), _paths(validate, "validate")
    chosen = _names(only, "only"), _names(without, "without"), _names(accept, "accept")
    options = DiagnosisOptions(preprocessing, _cutoff(cutoff), *chosen)
    # A file of the user is executed once: what the model was loaded with is there already.
    effects = model.library if model and not effect_files else library(_paths(effect_files, "effect_files"))
    return diagnosed(paths, held_out, effects, options, progress, model.file if model else None)


def _paths(files: object, name: str, least: int = 0) -> tuple[Path, ...]:
    """The paths that the argument `name` gives: one, or a list of them; None: none."""
    several = (files,) if isinstance(files, (str, Path)) else files or ()
    if not isinstance(several, Sequence) or not all(isinstance(file, (str, Path)) for file in several):
        raise TypeError(f"{name}: a path or a list of paths expected, {files!r} found")
    if len(several) < least:
        raise BadInput("at least one recording expected, none found; check the pattern or the folder")
    return tuple(map(Path, several))


def _names(names: object, name: str) -> tuple[str, ...]:
    """The names that the argument `name` gives: one, or a list of them."""
    several = (names,) if isinstance(names, str) else names
    if not isinstance(several, Sequence) or not all(isinstance(each, str) for each in several):
        raise TypeError(f"{name}: a name or a list of names expected, {names!r} found")
    return tuple(several)


def _cutoff(cutoff: object) -> float | None:
    if cutoff is None or isinstance(cutoff, Real):
        return None if cutoff is None else float(cutoff)
    raise TypeError(f"cutoff: a frequency in Hz expected, {cutoff!r} found")


def _check_model(model: object) -> None:
    from ident.identification.model import Model

    if not isinstance(model, Model):
        raise TypeError(f"model: a model of ident.fit or ident.load_model expected, {type(model).__name__} found")
