"""Diagnose random recordings: every result is finite, and whatever cannot be diagnosed is refused in a sentence."""

import io
import json
import re
import tempfile
import traceback
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator
from rich.console import Console

import ident
from ident.basics import plugins
from ident.dynamics.effects.library import library
from ident.estimation import estimators
from ident.output import pictures
from ident.output.console import diagnosis as diagnosis_table
from ident.output.console import fit as fit_table
from ident.output.console import residuals as residual_table
from ident.output.report import contents, page
from ident.workbench.worker.engine import SelectionEngine
from recordings.errors import BadInput
from tests.fuzz import recordings
from tests.fuzz.files import Outcome

MAX_ROWS = 1500
_UNREADABLE = re.compile(
    r"numpy|scipy|ndarray|\barray|\bshape|broadcast|operand|dtype|singular|SVD|\bNone\b|Traceback|\bnan\b|\binf\b",
    re.IGNORECASE,
)
"""What no sentence to a user contains."""
_NOT_A_NUMBER = re.compile(r"(?<![\w-])(nan|-?inf|None)(?![\w-])")
_METHODS = ("ls", "wls", "svd", "dls", "rls", "lad")
"""Estimators that take no time."""


def run(seed: int, folder: Path, rows: int = MAX_ROWS) -> Outcome:
    """Diagnose the random recordings of the case `seed`, of at most `rows` rows; files are written below `folder`."""
    rng, kind = np.random.default_rng(seed), "diagnosis"
    with warnings.catch_warnings(), tempfile.TemporaryDirectory(dir=folder) as name:
        warnings.simplefilter("error")
        try:
            _diagnose(rng, Path(name), rows)
        except BadInput as error:
            text = str(error).replace(name, "")
            wrong = _UNREADABLE.search(text) or text.count("\n") > 1
            return Outcome(seed, kind, text, f"sentence: {text}" if wrong else "")
        except Exception:
            return Outcome(seed, kind, failure=traceback.format_exc())
    return Outcome(seed, kind)


def _diagnose(rng: Generator, folder: Path, rows: int) -> None:
    machine = recordings.machine(rng)
    files = [recordings.write(folder, f"train_{i}", machine, rng, rows) for i in range(1 + (rng.random() < 0.1))]
    short = int(rng.integers(5, 150)) if rng.random() < 0.08 else rows
    validate = [recordings.write(folder, "validate", machine, rng, short)] if rng.random() < 0.5 else []
    preprocessing = str(rng.choice(plugins.names("ident.data.preprocessing"))) if rng.random() < 0.2 else "parallel"
    cutoff = None
    if preprocessing != "central" and (chosen := rng.random()) < 0.5:  # [Hz]
        cutoff = float(10 ** (rng.uniform(0.9, 1.3) if chosen < 0.45 else rng.uniform(-0.5, 2)))
    settings: dict[str, Any] = {"preprocessing": preprocessing, "cutoff": cutoff}
    effects = [
        name
        for name, effect in library(()).items()
        if machine.rig.mechanism in effect.mechanisms and not effect.mandatory
    ]
    only = [str(name) for name in rng.choice(effects, int(rng.integers(1, 4)), replace=False)]
    methods = [name for name in _METHODS if machine.rig.mechanism == "delta" or not estimators.form(name)]
    method, share = str(rng.choice(methods)), rng.random(4)

    model = None
    if share[0] < 0.2:
        held_out = validate[0] if validate else None
        added = only[:1] if share[1] < 0.3 and not estimators.form(method) else ()
        model = ident.fit(files, validate=held_out, method=method, effects=added, **settings)
        _check_model(model, files, validate, folder, draw=share[1] > 0.8)
    start = model if share[1] < 0.5 and not estimators.form(method) else None
    result = ident.diagnose(files, validate=validate, model=start, only=only if share[2] < 0.25 else (), **settings)
    json.dumps(result.as_json(), allow_nan=False)
    diagnosis_table.show(result.document, console := _console())
    _check_text("console", _printed(console))
    if share[3] < 0.15:
        request = contents.ReportRequest((), tuple(files), tuple(validate), (), diagnose=True)
        _check_page(page.render(contents.assemble(request, diagnosis=result)))
    if 0.3 < share[3] < 0.45:
        engine = SelectionEngine(lambda text: None)
        for view in (engine.view_recording(files[0]), engine.fit(files[0], validate[0] if validate else None)):
            list(view)
    if 0.1 < share[3] < 0.25:
        _check_model(result.model, files, validate, folder, draw=False)


def _check_model(
    model: ident.Model, files: Sequence[Path], validate: Sequence[Path], folder: Path, *, draw: bool
) -> None:
    console = _console()
    json.dumps(model.file.as_json(), allow_nan=False)
    if model.identification:  # else it was found by a diagnosis
        fit_table.show(model.file, model.identification, console, details=True)
    path = folder / "fuzz.model.json"
    model.save(path)
    comparison = ident.compare(ident.load_model(path), files)
    json.dumps(comparison.as_json(), allow_nan=False)
    residual_table.show(comparison, console)
    _check_text("console", _printed(console))
    if draw and model.identification:
        pictures.draw(model.identification, folder)
        request = contents.ReportRequest((path,), tuple(files), tuple(validate), (), diagnose=False)
        _check_page(page.render(contents.gather(request, lambda text: None)))


def _check_page(text: str) -> None:
    shown = re.sub(r"<(script|style)\b.*?</\1>", "", text, flags=re.DOTALL)
    _check_text("page", re.sub(r"<[^>]*>", " ", shown))


def _check_text(where: str, text: str) -> None:
    match = _NOT_A_NUMBER.search(text)
    assert not match, f"{where}: {text[max(match.start() - 100, 0) : match.end() + 50]}"


def _console() -> Console:
    return Console(file=io.StringIO(), width=200)


def _printed(console: Console) -> str:
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()
