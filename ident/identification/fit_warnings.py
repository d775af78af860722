"""What a model file itself tells against the model: its bounds, its intervals, its errors and its noise floor."""

from collections.abc import Iterator, Sequence
from math import sqrt

import numpy as np

from ident.identification.model_file import FittedParameter, ModelFile
from ident.uncertainty.fit_warning import FitWarning, WarningKind
from ident.uncertainty.identifiability import known_together

_MOST_NAMED = 5
"""Parameters that a sentence lists at most."""
_MAX_ERROR_RATIO = 10.0
"""Times the error in training up to which a held-out error is that of another motion."""
_NOTABLE_ERROR = 0.03
"""Error, in standard deviations of the torque, that is not put down to noise while samples are missing."""


def with_warnings(model: ModelFile, *others: FitWarning) -> ModelFile:
    """The `model` with its warnings and `others` in its assessment, behind those about what no machine can be."""
    if model.assessment is None:
        return model
    warnings = (*model.assessment.warnings, *_warnings(model), *others)
    return model.model_copy(update={"assessment": model.assessment.model_copy(update={"warnings": warnings})})


def _warnings(model: ModelFile) -> Iterator[FitWarning]:
    at_bound = [each for each in model.parameters if each.at_bound]
    yield from _about(at_bound, "at-bound", "At a limit, so not determined by these data")
    unknown = [each for each in model.parameters if not each.at_bound and not _is_known(each)]
    yield from _about(unknown, "not-determined", "Hardly determined by these data")
    if model.assessment:
        names = [each.name for each in model.parameters]
        for sentence in known_together(names, np.array(model.assessment.correlation, dtype=float)):
            yield FitWarning(sentence.partition(" are ")[0], True, sentence, kind="not-determined")
    test, errors = model.residual_test, _errors(model)
    if test and test.verdict == "above-noise":
        yield _of_all(
            "conditional",
            "Structure is left: the true values may lie far outside of the intervals.",
        )
    if model.validate_ and (question := about_held_out(errors[0], errors[-1])):
        yield _of_all("held-out", question)
    held = any(problem.kind == "held-samples" for problem in model.data_problems)
    if test and test.verdict == "within-noise" and (test.missing or held) and max(map(max, errors)) > _NOTABLE_ERROR:
        cause = f"{test.missing} samples are missing" if test.missing else "Samples are held"
        yield _of_all(
            "noise-floor",
            f"{cause}: what differs between cycles for that counts as noise, and may hide an effect; record again.",
        )


def about_held_out(training: Sequence[float], held_out: Sequence[float]) -> str | None:
    """The question whether another machine was held out, if that error is no longer that of another motion.

    training, held_out: errors of each joint, in standard deviations of its torque.
    """
    worst = max(held_out)
    joint = [*held_out].index(worst)
    if worst <= _NOTABLE_ERROR or (worst <= 1 and worst <= _MAX_ERROR_RATIO * training[joint]):
        return None
    return (
        f"Held out, the error of joint {joint + 1} is {worst:.0%} of what its torque varies by, in training "
        f"{training[joint]:.1%}: another robot, payload or rig file?"
    )


def _about(parameters: list[FittedParameter], kind: WarningKind, what: str) -> Iterator[FitWarning]:
    """A warning about all the `parameters`, if there are any."""
    if parameters:
        values = [f"{each.name} = {_value(each):.3g} {each.unit}" for each in parameters]
        others = f" and {len(values) - _MOST_NAMED} more" if len(values) > _MOST_NAMED else ""
        sentence = f"{what}: {', '.join(values[:_MOST_NAMED])}{others}."
        yield FitWarning(", ".join(each.name for each in parameters), True, sentence, kind=kind)


def _value(parameter: FittedParameter) -> float:
    """Its value; of one at a bound, that bound, without what the search left between."""
    ends = (parameter.lower, parameter.upper)
    return min(ends, key=lambda end: abs(end - parameter.value)) if parameter.at_bound else parameter.value


def _of_all(kind: WarningKind, sentence: str) -> FitWarning:
    return FitWarning(kind, True, sentence, kind=kind)


def _is_known(parameter: FittedParameter) -> bool:
    """Whether it has an interval, and one that excludes zero where it cannot be negative, as a mass."""
    limits = parameter.shape_ci95 or parameter.ci95
    return limits is not None and (limits[0] > 0 or parameter.lower < 0)


def _errors(model: ModelFile) -> list[list[float]]:
    """Errors of each joint in standard deviations of its torque: of the training data, then of those held out."""
    agreements = filter(None, (model.train, model.validate_))
    return [[sqrt(max(1 - r2, 0.0)) for r2 in each.fitted.r2] for each in agreements]
