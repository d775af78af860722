"""Warnings about recordings, and about what follows from them, that limit the validity of a diagnosis."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ident.basics.statistics import NORMAL
from ident.data.noise import is_filtered
from ident.data.samples import is_relative
from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import ParameterValue, joint_numbers
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.observability import MAX_RARE_SHARE, rarer_direction_share
from ident.diagnosis.split.split_data import SplitData, outside_of_range, rms, row_count, training_range
from ident.identification.fit_warnings import about_held_out
from ident.uncertainty.identifiability import known_together
from recordings.recording import Bools, Floats

_MIN_ROWS_PER_PARAMETER = 20
"""With fewer independent rows per parameter, small effects are not significant."""
_MIN_STANDSTILL = 0.01
"""Below this share of all rows, those near standstill are not reported."""
_MAX_ERROR_RATIO = 1.5
"""Largest plausible ratio between the errors on different recordings."""
_MIN_BLAME = 0.7
"""Share by which the error above the noise floor must be smaller in the rows inside of the range of the training data
than in all rows."""
_SURE = "Impossible: {}. A missing effect takes this part, or the sign of a torque or an angle is reversed."
_UNCERTAIN = (
    "Impossible, though perhaps by chance: {}. These data determine it poorly: the interval has possible values."
)
_UNUSUAL = "Unusual: {}. Look at the part itself before you compensate it: another effect may be taken for it."


def bound_warnings(
    parameters: Mapping[str, ParameterValue], usual: Mapping[str, tuple[float, float]]
) -> Iterator[str]:
    """Yield sentences that list the parameters outside of their physical bounds, and those of unusual size.

    usual: by name, where hardware usually stays between two values, ends excluded.
    """
    listed: dict[str, list[str]] = {_SURE: [], _UNCERTAIN: [], _UNUSUAL: []}
    for name, parameter in parameters.items():
        value, (low, high) = parameter.value, usual.get(name, (-np.inf, np.inf))
        lower = -np.inf if parameter.lower is None else parameter.lower
        upper = np.inf if parameter.upper is None else parameter.upper
        first, last = parameter.interval or (-np.inf, np.inf)
        cases = (
            (value < lower, _SURE if last < lower else _UNCERTAIN, f"below {lower:g}"),
            (value > upper, _SURE if first > upper else _UNCERTAIN, f"above {upper:g}"),
            (value <= low, _UNUSUAL, f"at most {low:g}"),
            (value >= high, _UNUSUAL, f"at least {high:g}"),
        )
        outside, kind, bound = next((case for case in cases if case[0]), (False, "", ""))
        if outside:
            listed[kind].append(f"{name} = {parameter.in_words} is {bound}")
    yield from (sentence.format("; ".join(entries)) for sentence, entries in listed.items() if entries)


def is_too_short(model: FittedModel) -> bool:
    """Whether the data may hide what the last `model` lacks: few rows confirm little, and fit much."""
    return model.split.independent_rows < _MIN_ROWS_PER_PARAMETER * len(model.solution.x)


def data_warnings(diagnosis: Diagnosis) -> tuple[str, ...]:
    """A sentence for everything that limits what the last model of a `diagnosis` is worth."""
    split, model, recording = diagnosis.split, diagnosis.model, diagnosis.split.recordings[0].recording
    rows, parameters = split.independent_rows, len(model.solution.x)
    truncated = file_names(split, [i for i, data in enumerate(split.recordings) if not data.recording.complete])
    falls = np.any([is_filtered(data) for data in split.recordings], axis=0)
    filtered = (np.flatnonzero(falls & (model.noise_floor.source == "spectrum")) + 1).tolist()
    cases = (
        (
            diagnosis.unexplained.significant,
            "An effect is still missing: until it is found, the errors of parameters may exceed their intervals.",
        ),
        (
            diagnosis.without_weight,
            "Without weight the last model explains these data much better: the drives may have taken gravity out of "
            "the torque that they report, or the URDF has another direction of it.",
        ),
        *((True, sentence) for sentence in _hardly_distinct(model)),
        (
            filtered,
            f"The noise of {joint_numbers(filtered)} falls off towards high frequencies: "
            "the drive filters its signal. The noise floor, which continues that noise as white, is a lower bound.",
        ),
        (truncated, f"Truncated: {', '.join(truncated)}. The rest of the motion is not known."),
        (
            is_too_short(model),
            f"Too short: {rows:.0f} independent rows for {parameters} parameters. Effects that were not found may "
            "still exist; record a longer motion.",
        ),
        *((True, sentence) for sentence in _disagreement(split, model)),
        *((True, sentence) for sentence in extrapolation_warnings(split, model)),
        (
            split.standstill_share > _MIN_STANDSTILL,
            f"{split.standstill_share:.0%} of the rows are left out of fits and errors: a joint is at or near "
            "standstill there, where dry friction may take any value up to its limit.",
        ),
        *((True, sentence) for sentence in unjudged_rows(split)),
        (
            is_relative(recording),
            f"The torque gain is assumed, within ± {100 * NORMAL * recording.rig.torque.gain_uncertainty:.2g} %: it "
            "scales all torques alike. Parameters that are proportional to the torque are RELATIVE; their intervals "
            "leave this factor out.",
        ),
    )
    return tuple(sentence for applies, sentence in cases if applies)


def unjudged_rows(split: SplitData) -> Iterator[str]:
    """Yield how many of the held-out rows say nothing for or against the model, and why."""
    shares = [f"{share:.1%} (joint {joint})" for joint, share in enumerate(split.unjudged_shares, start=1) if share]
    if shares:
        yield (
            f"Of the held-out rows, {' and '.join(shares)} are not scored, where the model says nothing: outside of "
            "the travel of the training data, for an effect that is a curve over it; and where the amplifiers are so "
            "near their limit, or in their dead band, that the voltage hardly depends on the torque. Train on a "
            "motion that goes there, too, and a slower one."
        )


def other_machine(model: FittedModel) -> str | None:
    """The question whether another machine was held out, if the last `model` predicts nothing there."""
    split = model.split
    if not split.other_motion:
        return None
    torque = [data.torque for data in split.recordings]
    with np.errstate(divide="ignore", invalid="ignore"):  # of a joint that was not moved, or whose torque is constant
        training, held_out = (
            np.nan_to_num(rms(model.residuals, rows) / _spread(torque, rows), posinf=0.0)
            for rows in (split.train, split.test)
        )
    return about_held_out(training.tolist(), held_out.tolist())


def _spread(values: Sequence[Floats], rows: Sequence[Bools]) -> Floats:
    """(dof,) standard deviation of `values` (m, dof) in the `rows`."""
    total = sum(np.nansum(np.where(*each, 0.0), axis=0) for each in zip(rows, values, strict=True))
    return rms([each - total / np.maximum(row_count(rows), 1) for each in values], rows)


def _hardly_distinct(model: FittedModel) -> Iterator[str]:
    """Yield which effects the motion hardly distinguishes, from each other or from the base model, and which parts
    of friction.
    """
    strengths = [
        i
        for i, entry in enumerate(model.solution.structure.parameters)
        if entry.linear and entry.free and not (entry.term >= 0 and model.terms[entry.term].effect.mandatory)
    ]
    names = [model.solution.structure.parameters[i].name for i in strengths]
    yield from known_together(names, model.uncertainty.correlation[np.ix_(strengths, strengths)])
    for joint, share in enumerate(rarer_direction_share(model.split), start=1):
        if share < MAX_RARE_SHARE:
            yield (
                f"Joint {joint} moves in one of its directions only {share:.0%} of the time, so its Coulomb friction "
                "and a constant offset are hardly distinct; record both directions equally."
            )


def file_names(split: SplitData, selected: Sequence[int]) -> list[str]:
    """File names of the `selected` recordings; with their folders where the names alone are ambiguous."""
    paths = [data.recording.path for data in split.recordings]
    names = [path.name for path in dict.fromkeys(paths)]
    return list(dict.fromkeys(paths[i].name if names.count(paths[i].name) == 1 else str(paths[i]) for i in selected))


def _disagreement(split: SplitData, model: FittedModel) -> Iterator[str]:
    """Whether the error of the last model is much larger on one of the files for the same purpose than on another."""
    names = [file_names(split, [i])[0] for i in range(len(split.recordings))]
    for purpose, subset in (("training", split.train), ("held-out", split.test)):
        levels = {}
        for name in dict.fromkeys(name for name, rows in zip(names, subset, strict=True) if rows.any()):
            parts = [i for i, other in enumerate(names) if other == name]
            levels[name] = np.linalg.norm(rms([model.residuals[i] for i in parts], [subset[i] for i in parts]))
        least = min(levels.values(), default=0.0)
        if max(levels.values(), default=0.0) > _MAX_ERROR_RATIO * least > 0:
            listing = ", ".join(f"{name}: {level / least:.2g}" for name, level in levels.items())
            yield (
                f"The {purpose} recordings disagree; the error of the last model on each, relative to the smallest: "
                f"{listing}. If the machine was changed between them, diagnose them one by one."
            )


def extrapolation_warnings(split: SplitData, model: FittedModel) -> Iterator[str]:
    """Yield a sentence for each joint whose held-out error is above the noise mostly out of the range of training.

    An effect that occurs only outside of that range, such as backlash without load reversal or saturation that was
    never reached, cannot be identified from the training data. The error in those rows is no evidence against the
    model.
    """
    floor, rig = model.noise_floor, split.recordings[0].recording.rig
    scored, residual = (np.concatenate(parts) for parts in (split.test, model.residuals))
    quantities = {
        "torque": ([data.torque for data in split.recordings], rig.effort_units),
        "speed": ([data.motion.velocity for data in split.recordings], [f"{unit}/s" for unit in rig.position_units]),
        "position": ([data.motion.position for data in split.recordings], rig.position_units),
    }
    failed = split.other_motion & (rms(model.residuals, split.test) > floor.limit)
    for joint in np.flatnonzero(failed).tolist():
        rows = scored[:, joint] & np.isfinite(residual[:, joint])
        excess = residual[rows, joint] ** 2 - floor.rms[joint] ** 2
        shares: dict[str, tuple[float, float]] = {}
        for name, (signals, units) in quantities.items():
            low, high = training_range(signals, split.train)
            outside = np.concatenate(outside_of_range(signals, low, high))[rows, joint]
            where = f"its {name} is outside of the {low[joint]:.3g} to {high[joint]:.3g} {units[joint]}"
            shares[where] = float(excess[outside].sum() / excess.sum()), float(outside.mean())
        where, (of_error, of_rows) = max(shares.items(), key=lambda item: item[1][0] - item[1][1])
        if of_error - of_rows > _MIN_BLAME * (1 - of_rows):
            yield (
                f"Joint {joint + 1}: {min(of_error, 1.0):.0%} of the held-out error (mean square above the noise "
                f"floor) is where {where} of the training data, in {of_rows:.0%} of the rows. Effects that occur "
                "only there cannot be identified from the training data: train on a motion that goes there, too."
            )
