"""All that is known about where a model fails, gathered, and as JSON."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ident.data import cycle_statistics
from ident.data.cycle_statistics import CycleStatistics
from ident.identification.model import Model
from ident.identification.prediction import Prediction
from ident.residuals import phases
from ident.residuals.curves import Curve, curves
from ident.residuals.spectrum import Spectrum, spectrum
from ident.residuals.windows import Window, worst
from recordings.recording import Floats

SCHEMA = 1
WORST = 6
"""Windows that are shown."""


@dataclass(frozen=True, eq=False)
class JointComparison:
    """One joint, all recordings together."""

    unit: str
    """Of its effort."""
    summary: phases.Joint
    split: CycleStatistics | None
    """Noise floor and what repeats; None where no motion is repeated."""
    curves: tuple[Curve, ...]
    spectrum: Spectrum


@dataclass(frozen=True, eq=False)
class Comparison:
    """A model against recordings."""

    model: Model | None
    """None for one on its way, of which there is no file yet."""
    predictions: tuple[Prediction, ...]
    joints: tuple[JointComparison, ...]
    windows: tuple[Window, ...]
    """Worst first."""

    @property
    def sentences(self) -> tuple[str, ...]:
        """What stands out, in words."""
        return phases.sentences([joint.summary for joint in self.joints])


def compare(model: Model | None, predictions: Sequence[Prediction]) -> Comparison:
    """Look at the residuals of `predictions`, which are those of `model`."""
    datasets = [prediction.dataset for prediction in predictions]
    splits = cycle_statistics.of_residuals(datasets, [prediction.residual for prediction in predictions])
    summaries = phases.joints(datasets, [prediction.computed for prediction in predictions])
    units = datasets[0].recording.rig.effort_units
    joints = tuple(
        JointComparison(
            unit=unit,
            summary=summary,
            split=splits[joint] if splits else None,
            curves=curves(predictions, joint),
            spectrum=spectrum(predictions, joint),
        )
        for joint, (unit, summary) in enumerate(zip(units, summaries, strict=True))
    )
    return Comparison(model, tuple(predictions), joints, worst(predictions, WORST))


def as_json(comparison: Comparison) -> dict[str, Any]:
    """The document that `ident compare --json` prints, as docs/compare.md describes it; its keys are stable."""
    datasets = [prediction.dataset for prediction in comparison.predictions]
    assert comparison.model is not None
    return {
        "schema": SCHEMA,
        "recordings": [dataset.recording.path.name for dataset in datasets],
        "simulated": any(dataset.recording.run.simulated for dataset in datasets),
        "relative": comparison.model.relative,
        "effects": list(comparison.model.effects),
        "bandwidth_hz": datasets[0].bandwidth,
        "joints": [_joint(joint) for joint in comparison.joints],
        "windows": [vars(window) for window in comparison.windows],
        "where": list(comparison.sentences),
    }


def _joint(joint: JointComparison) -> dict[str, Any]:
    summary, split = joint.summary, joint.split
    return {
        "joint": summary.number,
        "unit": joint.unit,
        "rms": summary.rms,
        "share_of_torque": summary.share,
        "noise_rms": split.noise_rms if split else None,
        "above_noise": split.above_noise if split else None,
        "phases": {name: vars(phase) for name, phase in summary.phases.items()},
        "curves": {curve.axis: _curve(curve) for curve in joint.curves},
        "spectrum": _spectrum(joint.spectrum),
    }


def _curve(curve: Curve) -> dict[str, Any]:
    return {
        "unit": curve.unit,
        "explained": curve.explained,
        **{name: _numbers(getattr(curve, name)) for name in ("centre", "mean", "half_width", "rms")},
        "samples": curve.samples.tolist(),
    }


def _spectrum(found: Spectrum) -> dict[str, Any]:
    densities = {"residual": found.residual, "torque": found.torque, "noise": found.noise}
    return {
        "frequency_hz": _numbers(found.frequency),
        **{name: None if density is None else _numbers(density) for name, density in densities.items()},
    }


def _numbers(x: Floats) -> list[float | None]:
    """JSON knows no NaN."""
    return [float(value) if np.isfinite(value) else None for value in x]
