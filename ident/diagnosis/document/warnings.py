"""Warnings about recordings, and about what follows from them, that limit the validity of a diagnosis."""

from collections.abc import Iterator, Sequence

import numpy as np

from ident.data.samples import holds_torque
from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.extrapolation import extrapolation_warnings
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.indistinguishable import indistinguishable
from ident.diagnosis.split.observability import MAX_RARE_SHARE, rarer_direction_share
from ident.diagnosis.split.split_data import SplitData, rms

_MIN_ROWS_PER_PARAMETER = 20
"""With fewer independent rows per parameter, small effects are not significant."""
_MIN_STANDSTILL = 0.01
"""Below this share of all rows, those near standstill are not reported."""
_MAX_ERROR_RATIO = 1.5
"""Largest plausible ratio between the errors on different recordings."""


def data_warnings(diagnosis: Diagnosis) -> Iterator[str]:
    """Yield a sentence for everything that limits what the last model of a `diagnosis` is worth."""
    split, model = diagnosis.split, diagnosis.model
    if diagnosis.unexplained.significant and diagnosis.selection.findings:
        yield "An effect is still missing: until it is found, the errors of parameters may exceed their intervals."
    yield from _known_together(model)
    yield from _rare_direction(split)
    yield from _insufficient_data(split, model)
    yield from _disagreement(split, model)
    yield from extrapolation_warnings(split, model)
    yield from _unscored_rows(split)
    recording = split.recordings[0].recording
    if recording.rig.torque.gain_source == "assumed" and not holds_torque(recording):
        yield (
            f"The torque gain is assumed, with an uncertainty of {recording.rig.torque.gain_uncertainty:.0%}: it "
            "scales all torques alike. Parameters that are proportional to the torque are RELATIVE; their intervals "
            "leave this factor out."
        )


def file_names(split: SplitData, selected: Sequence[int]) -> list[str]:
    """File names of the `selected` recordings; with their folders where the names alone are ambiguous."""
    paths = list(dict.fromkeys(data.recording.path for data in split.recordings))
    all_names = [path.name for path in paths]
    files = (split.recordings[i].recording.path for i in selected)
    return list(dict.fromkeys(path.name if all_names.count(path.name) == 1 else str(path) for path in files))


def _known_together(model: FittedModel) -> Iterator[str]:
    """Coefficients of two effects that the motion hardly distinguishes."""
    parameters = model.solution.structure.parameters
    for i, j, correlation in indistinguishable(model):
        yield (
            f"{parameters[i].name} and {parameters[j].name} are known only together: this motion hardly "
            f"distinguishes them (their errors correlate by {correlation:+.2f}), so one of the two effects may be "
            "all there is."
        )


def _rare_direction(split: SplitData) -> Iterator[str]:
    """Whether a joint moves mainly in one direction."""
    for joint, share in enumerate(rarer_direction_share(split), start=1):
        if share < MAX_RARE_SHARE:
            yield (
                f"Joint {joint} moves in one of its directions only {share:.0%} of the time, so its Coulomb friction "
                "and a constant offset are hardly distinct; record both directions equally."
            )


def _insufficient_data(split: SplitData, model: FittedModel) -> Iterator[str]:
    """Whether recordings are truncated or too short."""
    truncated = [i for i, data in enumerate(split.recordings) if not data.recording.complete]
    if truncated:
        yield f"Truncated: {', '.join(file_names(split, truncated))}. The rest of the motion is not known."
    rows, parameters = split.independent_rows, len(model.solution.x)
    if rows < _MIN_ROWS_PER_PARAMETER * parameters:
        yield (
            f"Too short: {rows:.0f} independent rows for {parameters} parameters. Effects that were not found may "
            "still exist; record a longer motion."
        )


def _disagreement(split: SplitData, model: FittedModel) -> Iterator[str]:
    """Whether the error of the last model is much larger on one of the files for the same purpose than on another."""
    for purpose, subset in (("training", split.train), ("held-out", split.test)):
        rows: dict[str, list[int]] = {}
        for i, selected in enumerate(subset):
            if selected.any():
                (name,) = file_names(split, [i])
                rows.setdefault(name, []).append(i)
        levels = {
            name: np.linalg.norm(rms([model.residuals[i] for i in indices], [subset[i] for i in indices]))
            for name, indices in rows.items()
        }
        least = min(levels.values(), default=0.0)
        if max(levels.values(), default=0.0) > _MAX_ERROR_RATIO * least > 0:
            listing = ", ".join(f"{name}: {level / least:.2g}" for name, level in levels.items())
            yield (
                f"The {purpose} recordings disagree; the error of the last model on each, relative to the smallest: "
                f"{listing}. If the machine was changed between them, diagnose them one by one."
            )


def _unscored_rows(split: SplitData) -> Iterator[str]:
    """Rows that neither fits nor errors use, or no errors."""
    if split.standstill_share > _MIN_STANDSTILL:
        yield (
            f"{split.standstill_share:.0%} of the rows are left out of fits and errors: a joint is at or near "
            "standstill there, where dry friction may take any value up to its limit."
        )
    if split.unjudged_shares:
        shares = " and ".join(
            f"{share:.1%} (joint {joint})" for joint, share in enumerate(split.unjudged_shares, start=1) if share
        )
        yield (
            f"Of the held-out rows, {shares} are not scored, where the model says nothing: outside of the travel of "
            "the training data, for friction that changes along the travel; and where the amplifiers are so near "
            "their limit, or in their dead band, that the voltage hardly depends on the torque. Train on a motion "
            "that goes there, too, and a slower one."
        )
