"""Export of a model to a target, with the document about what is lost."""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from ident.export import losses, paths, targets
from ident.export.losses import Carried
from ident.export.paths import TorquePath
from ident.export.torque_table import evaluate
from ident.identification.model import Model, rig_of
from ident.identification.model_file import text
from recordings.errors import BadInput, told
from recordings.reader import Source


def export(
    model: Model,
    target: str,
    out: Path,
    path: TorquePath,
    precision: Literal["double", "float"] = "double",
    given: Mapping[str, Any] | None = None,
    digest: str | None = None,
) -> Carried:
    """Write `model` for the `target` as `out`, and beside it what it carries along the motion `path`.

    given: settings of the target; digest: SHA-256 of the model file, None: of the one that `save` would write.

    Raises:
        BadInput: there is no such target or setting, or the model does not suit it.
    """
    exporter, settings = targets.load(target), targets.settings(target, given or {})
    evaluate(model, path.excerpt())  # refuses before anything is written
    digest = digest or hashlib.sha256(text(model.file).encode()).hexdigest()
    carried = exporter.write(targets.ExportRequest(model, path, out, settings, digest, precision))
    losses.write(model, carried, path, exporter.carried_file(out), target)
    return carried


def motion(model: Model, recording: Source | None, temperature: float | None = None) -> TorquePath:
    """The motion of `recording`; None: of a delta robot fig5a, at a `temperature` of the drives [degC].

    Raises:
        BadInput: the recording cannot be used, or there is none for a robot that fig5a does not suit.
    """
    if recording is not None:
        return paths.from_recording(recording, model.file)
    if model.file.mechanism != "delta":
        raise BadInput(
            f"{model.file.train.recordings[0].name}, the recording of the fit, is not at hand; give another one as "
            + told("--on or --csv", "on")
        )
    return paths.from_trajectory("fig5a", rig_of(model.file)).at_temperature(temperature)
