"""Complete analysis of a model's residual, and its JSON document."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ident.data import cycle_statistics
from ident.data.cycle_statistics import CycleStatistics
from ident.data_problems import listed
from ident.identification.model_file import ModelFile, ResidualTest
from ident.identification.prediction import Prediction
from ident.residuals import phases
from ident.residuals.curves import BinnedCurve, binned_curves
from ident.residuals.influences import MIN_EXPLAINED, Influence, strongest_influence
from ident.residuals.spectrum import Spectrum, spectrum
from recordings.data_problems import DataProblem
from recordings.notebook import html_table
from recordings.recording import Floats

SCHEMA = 2
WINDOWS = 6
"""Number of windows that are shown."""


@dataclass(frozen=True, eq=False)
class JointAnalysis:
    """Residual analysis of one joint over all recordings."""

    unit: str
    """Unit of its effort."""
    summary: phases.JointResidual
    split: CycleStatistics | None
    """What differs between repetitions, and what repeats; None if no motion is repeated."""
    noise_rms: float | None
    """Noise floor: differences between repetitions, and quantization; None if it is not known."""
    curves: tuple[BinnedCurve, ...]
    spectrum: Spectrum

    @property
    def above_noise(self) -> float | None:
        """Share of the mean square in scored rows above the noise floor, 0 to 1; None if the floor is not known."""
        if self.noise_rms is None:
            return None
        return max(1 - (self.noise_rms / self.summary.rms) ** 2, 0.0) if self.summary.rms else 0.0


@dataclass(frozen=True, eq=False, repr=False)
class ResidualAnalysis:
    """Residual analysis of a model on recordings."""

    model: ModelFile | None
    """None if the model has not been saved to a file yet."""
    predictions: tuple[Prediction, ...]
    joints: tuple[JointAnalysis, ...]
    windows: tuple[phases.Window, ...]
    """Worst first."""
    test: ResidualTest | None = None
    """Of the residual against the noise floor; None if the model cannot be tested."""

    def __repr__(self) -> str:
        """One line: the recordings and the error."""
        files = ", ".join(dict.fromkeys(each.prepared.recording.path.name for each in self.predictions))
        errors = ", ".join(f"{joint.summary.rms:.3g} {joint.unit}" for joint in self.joints)
        return f"<ResidualAnalysis of {files}: RMS {errors}>"

    def _repr_html_(self) -> str:
        """The residual of each joint as a table below the verdict, for a notebook."""
        rows = [
            (
                f"{joint.summary.number}",
                f"{joint.summary.rms:.3g} {joint.unit}",
                f"{joint.summary.share:.1%}",
                "unknown" if joint.noise_rms is None else f"{joint.noise_rms:.3g} {joint.unit}",
            )
            for joint in self.joints
        ]
        head = ("joint", "RMS residual", "of RMS torque", "noise floor")
        return html_table(self.test.sentence if self.test else self.sentences[0], head, rows)

    def plot(self) -> Any:
        """A Plotly figure of the mean residual over each quantity, joint by joint."""
        from ident.output.figures.residuals import curves

        return curves({"model": self})

    @property
    def within_noise(self) -> bool:
        """Whether nothing structured is left above the noise floor."""
        return self.test is not None and self.test.verdict == "within-noise"

    @cached_property
    def influences(self) -> tuple[Influence, ...]:
        """What explains most of each joint's residual. Computed when asked for: most pages do without."""
        return tuple(strongest_influence(self.predictions, joint) for joint in range(len(self.joints)))

    @property
    def data_problems(self) -> tuple[DataProblem, ...]:
        """What cannot be right about the recordings, but does not keep from using them."""
        recordings = [prediction.prepared.recording for prediction in self.predictions]
        return listed(recordings, [prediction.problems for prediction in self.predictions])

    @property
    def sentences(self) -> tuple[str, ...]:
        """What explains most of the residual; the verdict in words; what else is notable if it is not noise."""
        shares = ", ".join(f"joint {each.summary.number} {100 * each.summary.share:.1f} %" for each in self.joints)
        test = (self.test.sentence,) if self.test else ()
        size = f"RMS residual, in percent of the joint's RMS torque: {shares}."
        if self.within_noise:
            return (*test, size)
        leading, *others = self._influence_sentences()
        by_phase = (line for joint in self.joints for line in joint.summary.sentences)
        return (leading, size, *test, *others, *by_phase)

    def _influence_sentences(self) -> Iterator[str]:
        """One for each joint, that of the largest torque first, relative to the joint's own."""
        rig = self.predictions[0].prepared.recording.rig
        explained = sorted(
            zip(self.influences, self.joints, strict=True),
            key=lambda each: -each[0].explained * each[1].summary.share ** 2,
        )
        units = ["metre" if unit == "m" else "turn" for unit in rig.position_units]
        named = [
            influence.sentence(joint.summary.number, units[joint.summary.number - 1])
            for influence, joint in explained
            if influence.explained >= MIN_EXPLAINED
        ]
        yield from named or [
            f"No quantity explains {100 * MIN_EXPLAINED:.0f} % of the squared residual of any joint."
        ]

    def as_json(self) -> dict[str, Any]:
        """Return the document of `ident compare --json`, whose keys are stable: docs/reference/compare-json.md."""
        recordings = [prediction.prepared for prediction in self.predictions]
        assert self.model is not None
        return {
            "schema": SCHEMA,
            "recordings": [prepared.recording.path.name for prepared in recordings],
            "data_problems": [problem.model_dump(mode="json") for problem in self.data_problems],
            "simulated": any(prepared.recording.run.simulated for prepared in recordings),
            "relative": self.model.relative,
            "effects": list(self.model.effects),
            "bandwidth_hz": recordings[0].bandwidth,
            "verdict": self.test.verdict if self.test else "unknown",
            "joints": [
                _joint(joint) | {"influence": vars(influence)}
                for joint, influence in zip(self.joints, self.influences, strict=True)
            ],
            "windows": [vars(window) for window in self.windows],
            "where": list(self.sentences),
        }


def analyse(
    model: ModelFile | None, predictions: Sequence[Prediction], test: ResidualTest | None = None
) -> ResidualAnalysis:
    """Analyse the residuals of the `predictions` of `model`, and judge them by their `test`."""
    recordings = [prediction.prepared for prediction in predictions]
    splits = cycle_statistics.of_residuals(recordings, [prediction.residual for prediction in predictions])
    summaries = phases.joint_residuals(predictions)
    units = recordings[0].recording.rig.effort_units
    joints = tuple(
        JointAnalysis(
            unit=unit,
            summary=summary,
            split=splits[joint] if splits else None,
            noise_rms=test.noise_rms[joint] if test else None,
            curves=binned_curves(predictions, joint),
            spectrum=spectrum(predictions, joint),
        )
        for joint, (unit, summary) in enumerate(zip(units, summaries, strict=True))
    )
    return ResidualAnalysis(model, tuple(predictions), joints, phases.worst_windows(predictions, WINDOWS), test)


def _joint(joint: JointAnalysis) -> dict[str, Any]:
    summary, split = joint.summary, joint.split
    return {
        "joint": summary.number,
        "unit": joint.unit,
        "rms": summary.rms,
        "rms_all": summary.rms_all,
        "share_of_torque": summary.share,
        "noise_rms": joint.noise_rms,
        "repetition_rms": split.noise_rms if split else None,
        "above_noise": joint.above_noise,
        "phases": {name: vars(phase) for name, phase in summary.phases.items()},
        "curves": {curve.axis: _curve(curve) for curve in joint.curves},
        "spectrum": _spectrum(joint.spectrum),
    }


def _curve(curve: BinnedCurve) -> dict[str, Any]:
    return {
        "unit": curve.unit,
        "explained": curve.explained,
        **{name: _numbers(getattr(curve, name)) for name in ("centre", "mean", "half_width", "rms")},
        "samples": curve.samples.tolist(),
    }


def _spectrum(spectrum: Spectrum) -> dict[str, Any]:
    densities = {"residual": spectrum.residual, "torque": spectrum.torque, "noise": spectrum.noise}
    return {
        "frequency_hz": _numbers(spectrum.frequency),
        **{name: None if density is None else _numbers(density) for name, density in densities.items()},
    }


def _numbers(x: Floats) -> list[float | None]:
    """Replace NaN by None, because JSON has no NaN."""
    return [float(value) if np.isfinite(value) else None for value in x]
