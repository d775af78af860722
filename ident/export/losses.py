"""What an exported model carries of the identified one, and the torque that is lost by what it does not."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ident.dynamics.motion import Motion
from ident.export.paths import TorquePath
from ident.export.torque_table import TorqueSummary, evaluate
from ident.identification.model import Model
from recordings.recording import Floats


@dataclass(frozen=True)
class Carried:
    """Effects of a model by what becomes of them in an export."""

    carried: tuple[str, ...]
    lost: Mapping[str, str]
    """Effects and other causes that are not carried, and why."""
    voltage: tuple[str, ...]
    """Effects on what the drives report: they change no torque."""
    parts: Mapping[str, Callable[[Motion], Floats]] = field(default_factory=dict)
    """Torque (n, dof) of those that are lost and are a part of a term only."""


def sorted_by(model: Model, reasons: Mapping[str, str], others: Mapping[str, str] = {}) -> Carried:
    """Sort the effects of `model`; reasons: why some cannot be carried; others: causes that are lost, too."""
    structure = model.dynamics.structure
    voltage = {
        structure.term_names[index]
        for index, _, effect in structure.signals
        if effect.distorts_report and not effect.corrects_motion
    }
    lost = {name: reasons[name] for name in structure.term_names if name in reasons and name not in voltage}
    kept = tuple(name for name in structure.term_names if name not in voltage and name not in lost)
    return Carried(kept, {**lost, **others}, tuple(name for name in structure.term_names if name in voltage))


def write(model: Model, carried: Carried, path: TorquePath, out: Path, target: str) -> None:
    """Write the document `out`: effects carried and lost, with the RMS torque that is lost along `path`."""
    whole, losses = TorqueSummary(), TorqueSummary()
    for chunk in path.chunks():
        torque, terms = evaluate(model, chunk)
        gone = {
            name: carried.parts[name](chunk.motion)[chunk.used] if name in carried.parts else terms[name]
            for name in carried.lost
        }
        whole.add(torque, {})
        losses.add(np.sum([np.zeros_like(torque), *gone.values()], axis=0), gone)
    rms = losses.rms
    document = {
        "schema": 1,
        "target": target,
        "motion": path.name,
        "torque_rms": whole.torque_rms.tolist(),
        "torque_lost_rms": losses.torque_rms.tolist(),
        "carried": list(carried.carried),
        "not_carried": [
            {"effect": name, "why": why, "torque_lost_rms": rms[name].tolist()} for name, why in carried.lost.items()
        ],
        "voltage_only": list(carried.voltage),
    }
    out.write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")
