"""Physical plausibility of an effect: rules that decide before statistics do, each with the reason of a refusal.

The limits are those that effects declare (`Quantity` and `Effect`), and those of the mechanism's parameters.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ident.diagnosis.judge.confirmation import MIN_T, is_supported
from ident.diagnosis.judge.steps import FittedModel
from ident.dynamics.effects.base import Quantity
from ident.dynamics.structure import Term
from ident.dynamics.torque_map import voltage_from_torque
from recordings.recording import Floats, Ints

MIN_SHAPE_EFFECT = 0.01
"""A shape parameter is identifiable if moving it across its range changes the residual by more than this share of the
remaining loss, in squares."""
_SIGN_TOLERANCE = 0.1
"""A positive parameter may become negative, and one with limits leave them, by this share of its former value by
chance."""
_MINOR_SHARE = 0.2
"""Torque of a negative parameter, relative to that of the effect that made it so, below which it is no objection."""
_MAX_LINE_WIDTH = 0.05
"""Largest half-width of the interval of a line's order, relative to it: a line is narrow."""
_LEVEL = 0.95
"""Confidence level at which a strength differs from zero."""


def within_limits(model: FittedModel) -> list[bool]:
    """For each instance of the last term, whether its local parameters are possible, and no larger than plausible."""
    return plausible_instances(model.terms[-1], _local_values(model))


def plausible_instances(term: Term, local: Floats) -> list[bool]:
    """For each instance of `term`, whether its parameters `local` (instances, c) are possible and plausibly small."""
    sizes = np.linalg.norm(local, axis=1)
    return [
        possible and bool(size <= _max_amplitude(term))
        for possible, size in zip(_possible(term, local), sizes, strict=True)
    ]


def _possible(term: Term, local: Floats) -> list[bool]:
    """For each instance of `term`, whether its parameters `local` (instances, c) are within their physical limits."""
    lower, upper = (
        np.array([getattr(quantity, side) for quantity in term.local_parameters]) for side in ("lower", "upper")
    )
    return [bool(((lower <= row) & (row <= upper)).all()) for row in local]


def _amplitudes(model: FittedModel, index: int) -> list[float]:
    """Amplitude of each instance of the term `index`."""
    local = model.solution.structure.local_values(index % len(model.terms), model.solution.x)
    return [float(np.linalg.norm(row)) for row in local]


def _max_amplitude(term: Term) -> float:
    """Largest plausible amplitude of `term`."""
    limit = term.effect.max_amplitude
    return np.inf if limit is None else limit


def is_physical(model: FittedModel, before: FittedModel) -> bool:
    """Whether the last term of `model` and its influence on the mechanism's parameters are physically possible."""
    return implausibility(model, before) is None


def implausibility(model: FittedModel, before: FittedModel) -> str | None:
    """The first reason why the last term of `model`, fitted in addition to `before`, cannot be true; or None."""
    return next(_reasons(model, before), None)


def _reasons(model: FittedModel, before: FittedModel) -> Iterator[str]:
    """Reasons against the values of the last term."""
    if not all(_possible(model.terms[-1], _local_values(model))):
        yield "it would need a size or a sign that is not possible"
    flipped = flipped_parameter(model, before) or _earlier_effect_impossible(model, before)
    if flipped:
        yield f"{flipped} would get a value that is not possible"
    yield from _reasons_of_shape(model, len(model.terms) - 1)
    yield from _excessive_amplitude(model)


def implausible_shape(model: FittedModel, index: int) -> str | None:
    """The first reason why the shape of the term `index` of `model` cannot be true; or None.

    A shape was plausible when its effect was added, but may be so no longer once another effect is gone.
    """
    return next(_reasons_of_shape(model, index), None)


def _reasons_of_shape(model: FittedModel, index: int) -> Iterator[str]:
    """Reasons against the shape of the term `index`."""
    if _shape_at_limit(model, index):
        yield "the search for its shape ended at the end of the plausible range"
    yield from _shapes_beyond_the_data(model, index)


def is_only_large(model: FittedModel, before: FittedModel) -> bool:
    """Whether the amplitude of the last term of `model` is the only reason against it."""
    reason = implausibility(model, before)
    return reason is not None and reason in _excessive_amplitude(model)


def _excessive_amplitude(model: FittedModel) -> Iterator[str]:
    """The reason against a last term that is larger than hardware usually has."""
    if (size := max(_amplitudes(model, -1))) > (limit := _max_amplitude(model.terms[-1])):
        yield f"it would need an amplitude of {size:.3g}; at most {limit:.3g} is plausible"


def _local_values(model: FittedModel) -> Floats:
    """(instances, c) local parameters of the last term."""
    return model.solution.structure.local_values(len(model.terms) - 1, model.solution.x)


def flipped_parameter(model: FittedModel, before: FittedModel) -> str | None:
    """Name of a positive parameter of the mechanism that `model` makes negative and that was not so `before`.

    An example is friction that drives the motion. While much is missing, a parameter may be negative by chance, or
    where its torque is small beside that of the last term.
    """
    parameters = model.solution.structure.mechanism.parameters
    positive = np.array([parameter.physically_positive for parameter in parameters])
    now, then = (fitted.solution.x[: len(parameters)] for fitted in (model, before))
    flipped = positive & (then >= 0) & (now < -_SIGN_TOLERANCE * np.abs(then))
    if flipped.any():
        error = model.uncertainty.std[: len(parameters)]
        flipped &= ~(now > -MIN_T * error)  # refused where the error is not known
        flipped &= _torque_sizes(model)[: len(parameters)] > _MINOR_SHARE * _term_torque(model)
    return parameters[int(np.argmax(flipped))].name if flipped.any() else None


def sign_warnings(model: FittedModel) -> Iterator[str]:
    """Parameters of the mechanism that are surely negative and cannot be."""
    solution = model.solution
    parameters = solution.structure.mechanism.parameters
    error = model.uncertainty.std[: len(parameters)]
    values = solution.x[: len(parameters)]
    names = [
        f"{parameter.name} = {value:.3g} {parameter.unit}"
        for parameter, value, std in zip(parameters, values, error, strict=True)
        if parameter.physically_positive and value < -MIN_T * std
    ]
    if names:
        yield (
            f"Not physical: {', '.join(names)} cannot be negative. Something is missing that takes this part, or the "
            "sign of the torque is reversed."
        )


def size_warnings(model: FittedModel) -> Iterator[str]:
    """Effects of `model` that are larger than hardware usually has."""
    for index, term in enumerate(model.terms):
        if (size := max(_amplitudes(model, index))) > (limit := _max_amplitude(term)):
            yield (
                f"{term.name} of {size:.3g} is larger than hardware usually has ({limit:.3g}), but nothing else "
                "comes near what it explains. Look at the part itself before it is compensated."
            )


def _torque_sizes(model: FittedModel) -> Floats:
    """(K,) weighted RMS torque of each parameter times its derivative, up to a common factor."""
    regressor, _ = model.solution.rows()
    sizes: Floats = np.sqrt((regressor**2).sum(axis=0)) * np.abs(model.solution.x)
    return sizes


def _term_torque(model: FittedModel) -> float:
    """The same for all linear coefficients of the last term together; 0 if it has none."""
    structure = model.solution.structure
    linear = structure.parameter_mask(len(model.terms) - 1) & structure.linear
    return float(np.linalg.norm(model.solution.rows()[0][:, linear] @ model.solution.x[linear]))


def _earlier_effect_impossible(model: FittedModel, before: FittedModel) -> str | None:
    """Name of a coefficient of an earlier effect that `model` moves out of its range and that was inside `before`."""
    values = dict(zip((entry.name for entry in before.solution.structure.parameters), before.solution.x, strict=True))
    for entry, now in zip(model.solution.structure.parameters, model.solution.x, strict=True):
        then = values.get(entry.name, np.nan)
        tolerance = _SIGN_TOLERANCE * abs(then)
        if (
            entry.term >= 0
            and entry.lower <= then <= entry.upper
            and not (entry.lower - tolerance <= now <= entry.upper + tolerance)
        ):
            return entry.name
    return None


def _shape_at_limit(model: FittedModel, index: int) -> bool:
    """Whether a shape of the term `index` stopped at a limit that is not physical, and test rows confirm it there."""
    quantities, structure = model.terms[index].shapes, model.solution.structure
    values = structure.shape_values(index, model.solution.x)
    entries = np.flatnonzero(structure.parameter_mask(index))[-len(values) :].tolist() if len(values) else []
    return any(
        (
            (shape.implausible_bound == "upper" and value >= shape.upper)
            or (shape.implausible_bound == "lower" and value <= shape.lower)
        )
        and _is_identifiable(model, entry, shape.upper - shape.lower)
        and _is_needed_at_limit(model, index, entry, shape)
        for entry, shape, value in zip(entries, quantities, values, strict=True)
    )


def _is_identifiable(model: FittedModel, entry: int, span: float) -> bool:
    """Whether the loss depends on entry `entry` of the parameter vector anywhere in its range `span`."""
    pairs = zip(model.solution.weights, model.solution.derivatives, strict=True)
    changed = sum(float(np.nansum((weight * by_x[:, :, entry] * span) ** 2)) for weight, by_x in pairs)
    return changed > MIN_SHAPE_EFFECT * model.solution.loss


def _is_needed_at_limit(model: FittedModel, index: int, entry: int, shape: Quantity) -> bool:
    """Whether test rows confirm a `shape` of the term `index` at its limit over the nearest initial guess, if any."""
    if not shape.initial_guesses:
        return True
    effect, x = model.terms[index].effect, model.solution.x.copy()
    x[entry] = min(shape.initial_guesses, key=lambda guess: abs(guess - x[entry]))
    shapes = tuple(replace(each, searched=False) if each.name == shape.name else each for each in effect.shapes)
    structure = model.solution.structure.with_effect(index, replace(effect, shapes=shapes))
    return is_supported(model.improvement_over(FittedModel(model.split, model.split.fit(structure, x))))


def _shapes_beyond_the_data(model: FittedModel, index: int) -> Iterator[str]:
    """Reasons against time constants, limits and waves that the recordings are too short, slow or narrow to show."""
    term = model.terms[index]
    shapes = model.solution.structure.shape_values(index, model.solution.x)
    for shape, value in zip(term.shapes, shapes, strict=True):
        if shape.max_durations is not None and abs(value) > shape.max_durations * (longest := _duration(model)):
            yield f"its {shape.name} of {value:.3g} {shape.unit} is far longer than the recording of {longest:.3g} s"
    for column, quantity in enumerate(term.local_parameters):
        if quantity.min_use is not None and _largest_use(model, index, column) < quantity.min_use:
            yield "the level that it would need was never approached"
    if term.effect.repeated and (wave := _longest_wave(term, shapes)) > (travel := _travel(model, term)):
        yield f"its period of {wave:.3g} is longer than the travel of {travel:.3g}: a curve over the angle, no ripple"


def _duration(model: FittedModel) -> float:
    """Duration of the longest training recording [s]."""
    recordings = (model.split.recordings[i] for i in model.split.train_indices)
    return max(float(recording.time[-1] - recording.time[0]) for recording in recordings)


def _largest_use(model: FittedModel, index: int, column: int) -> float:
    """Largest product of the parameter `column` of the term `index` and the voltage, over joints and recordings.

    Those that are held out count as well: where they approach a level that the others only point to, they judge it.
    """
    recordings, joints = model.split.recordings, list(model.terms[index].joints)
    local = model.solution.structure.local_values(index, model.solution.x)
    torque_map = recordings[0].recording.rig.torque
    largest = [
        np.nanmax(np.abs(voltage_from_torque(recording.torque, torque_map))[:, joints], axis=0)
        for recording in recordings
    ]
    return float((np.max(largest, axis=0) * local[:, column]).max())


def _longest_wave(term: Term, shapes: Floats) -> float:
    """Period of the line of a spectrum over the position [rad or m]; 0 for other effects."""
    periods = [2 * np.pi / value for shape, value in zip(term.shapes, shapes, strict=True) if value > 0]
    return max(periods, default=0.0)


def _travel(model: FittedModel, term: Term) -> float:
    """Travel in the training rows of the joint of `term` that moves farthest [rad or m]."""
    split, joints = model.split, list(term.joints)
    positions = np.concatenate([split.predictors[i].prepared.motion.position[:, joints] for i in split.train_indices])
    return float((np.nanmax(positions, axis=0) - np.nanmin(positions, axis=0)).max())


def unresolved(model: FittedModel) -> str | None:
    """The reason why the data do not determine the strength of the last term of `model`, or None.

    No strength differs from zero, the sign of a time constant is not known, or strengths that must have
    the same sign do not.
    """
    if not any(resolved_instances(model, len(model.terms) - 1)):
        return "its strength is zero within its interval"
    term, effect = model.terms[-1], model.terms[-1].effect
    half_width = model.uncertainty.half_width()
    first = len(model.solution.x) - len(term.shapes)
    for entry, shape in enumerate(term.shapes, start=first):
        if shape.max_durations is not None and abs(model.solution.x[entry]) < half_width[entry]:
            return f"its {shape.name} is zero within its interval"
        if effect.repeated and half_width[entry] > _MAX_LINE_WIDTH * abs(model.solution.x[entry]):
            return f"its {shape.name} is not determined: a piece of a curve, no line"
    if effect.same_sign:
        local, width = _local_values(model), half_width[_local_entries(model, -1)]
        if ((local > width).any(axis=1) & (local < -width).any(axis=1)).any():
            return "its parts would need opposite signs"
    return None


def resolved_instances(model: FittedModel, index: int) -> list[bool]:
    """For each instance of the term `index`, whether its local parameters together differ from zero.

    What repeats with the motion counts as in the intervals that are reported: no effect is named on a joint beside an
    interval that holds zero.
    """
    covariance = model.uncertainty.covariance + np.diag(model.propagated_variance)
    local = model.solution.structure.local_values(index, model.solution.x)
    instances = zip(local, _local_entries(model, index), strict=True)
    return [_differs_from_zero(values, covariance[np.ix_(entries, entries)]) for values, entries in instances]


def _local_entries(model: FittedModel, index: int) -> Ints:
    """(instances, c) entries of the local parameters of the term `index` in the parameter vector."""
    index %= len(model.terms)
    shape = model.solution.structure.local_values(index, model.solution.x).shape
    entries = np.flatnonzero(model.solution.structure.parameter_mask(index))
    return entries[: shape[0] * shape[1]].reshape(shape)


def _differs_from_zero(values: Floats, covariance: Floats) -> bool:
    """Whether `values` (c,) together differ from zero, by Wald's test."""
    from scipy.special import chdtri

    known = np.isfinite(np.diag(covariance))
    if not known.any():
        return False
    statistic = values[known] @ np.linalg.pinv(covariance[np.ix_(known, known)]) @ values[known]
    return bool(statistic > chdtri(known.sum(), 1 - _LEVEL))


def simpler_effect(model: FittedModel, index: int = -1) -> str | None:
    """The effect that the term `index` of `model` reduces to, because its distinguishing parameter may be zero.

    None where there is none. The parameter must not differ from zero on any joint, by the t of an improvement.
    """
    term = model.terms[index]
    columns = [i for i, quantity in enumerate(term.local_parameters) if quantity.reduces_to]
    if not columns:
        return None
    local = model.solution.structure.local_values(index % len(model.terms), model.solution.x)
    error = model.standard_errors[_local_entries(model, index)]
    for column in columns:
        if not (np.abs(local[:, column]) > MIN_T * error[:, column]).any():
            return term.local_parameters[column].reduces_to
    return None
