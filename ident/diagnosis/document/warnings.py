"""Warnings about recordings that limit the validity of a diagnosis."""

from collections.abc import Iterator, Sequence

import numpy as np

from ident.data.samples import holds_torque
from ident.diagnosis.document.extrapolation import extrapolation_warnings
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.noise_floor import NoiseFloor
from ident.diagnosis.split.observability import MAX_RARE_SHARE, rarer_direction_share
from ident.diagnosis.split.split_data import SplitData, rms

_MIN_ROWS_PER_PARAMETER = 20
"""With fewer independent rows per parameter, small effects are not significant."""
_MIN_STANDSTILL = 0.01
"""Below this share of all rows, those near standstill are not reported."""
_MAX_ERROR_RATIO = 1.5
"""Largest plausible ratio between the errors on different test recordings."""


def data_warnings(split: SplitData, model: FittedModel, floor: NoiseFloor) -> Iterator[str]:
    """Warnings about the recordings of a `model` with its noise `floor`."""
    yield from _rare_direction(split)
    yield from _insufficient_data(split, model)
    yield from _disagreement(split, model, floor)
    yield from extrapolation_warnings(split, model, floor)
    yield from _excluded_rows(split)
    yield from _assumed_gain(split)


def file_names(split: SplitData, selected: Sequence[int]) -> list[str]:
    """File names of the `selected` recordings; with their folders where the names alone are ambiguous."""
    paths = list(dict.fromkeys(data.recording.path for data in split.recordings))
    all_names = [path.name for path in paths]
    files = (split.recordings[i].recording.path for i in selected)
    return list(dict.fromkeys(path.name if all_names.count(path.name) == 1 else str(path) for path in files))


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


def _disagreement(split: SplitData, model: FittedModel, floor: NoiseFloor) -> Iterator[str]:
    """Whether the error of the final model is much larger on one test recording than on another."""
    if not floor.rms.any():
        return
    test = [i for i, rows in enumerate(split.test) if rows.any()]
    errors: dict[str, float] = {}
    for name in file_names(split, test) if split.other_motion else ():
        indices = [i for i in test if file_names(split, [i]) == [name]]
        level = rms([model.residuals[i] for i in indices], [split.test[i] for i in indices])
        errors[name] = float(np.linalg.norm(level) / np.linalg.norm(floor.rms))
    if len(errors) > 1 and max(errors.values()) > _MAX_ERROR_RATIO * min(errors.values()):
        listing = ", ".join(f"{name}: {error:.2g}" for name, error in errors.items())
        yield (
            f"The held-out recordings disagree; ratio of the final model's error to the noise floor: {listing}. "
            "Was the machine changed between them? Diagnose them one by one."
        )


def _excluded_rows(split: SplitData) -> Iterator[str]:
    """Rows that are not scored."""
    if split.standstill_share > _MIN_STANDSTILL:
        yield (
            f"{split.standstill_share:.0%} of the rows are left out of fits and errors because a joint is at or near "
            "standstill, where its dry friction is not determined."
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


def _assumed_gain(split: SplitData) -> Iterator[str]:
    recording = split.recordings[0].recording
    if recording.rig.torque.gain_source == "assumed" and not holds_torque(recording):
        share = recording.rig.torque.gain_uncertainty
        yield (
            f"The torque gain is assumed, with an uncertainty of {share:.0%}: it scales all torques alike. "
            "Parameters that are proportional to the torque are RELATIVE; their intervals leave this factor out."
        )
