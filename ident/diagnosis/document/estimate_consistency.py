"""Contradictions between estimates of the same effect: of different files or steps, and beside other effects."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from ident.data.prepared_recording import MIN_ROWS_PER_PARAMETER
from ident.diagnosis.document.document import ParameterValue, StepEntry
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_T
from ident.diagnosis.judge.indistinguishable import indistinguishable, is_strength
from ident.diagnosis.split.split_data import SplitData
from recordings.recording import Floats

MAX_RATIO = 2.0
"""Estimates of the same parameter that differ by more than this factor contradict each other, if it is no chance."""


def consistency_warnings(model: FittedModel, steps: Sequence[StepEntry]) -> Iterator[str]:
    """Yield a sentence for each contradiction about the effects of the final `model`, reached by the `steps`."""
    yield from _between_effects(model)
    yield from _between_files(model)
    yield from _between_steps(steps)


def _between_effects(model: FittedModel) -> Iterator[str]:
    """Coefficients of two effects that the motion hardly distinguishes."""
    parameters = model.solution.structure.parameters
    for i, j, correlation in indistinguishable(model):
        yield (
            f"{parameters[i].name} and {parameters[j].name} are known only together: this motion hardly "
            f"distinguishes them (their errors correlate by {correlation:+.2f}), so one of the two may be all there "
            "is."
        )


def _between_files(model: FittedModel) -> Iterator[str]:
    """Coefficients that differ between the training files if each is fitted alone."""
    split = model.split
    names = {i: split.recordings[i].recording.path for i in split.train_indices}
    files = [path for path in dict.fromkeys(names.values()) if _is_long_enough(model, path)]
    entries = [i for i in range(len(model.solution.x)) if is_strength(model, i)]
    if len(files) < 2 or not entries:
        return
    fits = [_fit_alone(model, [i for i, path in names.items() if path == file]) for file in files]
    values, errors = (np.stack(part) for part in zip(*fits, strict=True))
    for entry in entries:
        low, high = int(values[:, entry].argmin()), int(values[:, entry].argmax())
        difference = values[high, entry] - values[low, entry]
        chance = MIN_T * np.hypot(errors[low, entry], errors[high, entry])
        if difference > chance and _contradict(values[low, entry], values[high, entry]):
            parameter = model.solution.structure.parameters[entry]
            estimates = ", ".join(
                f"{values[i, entry]:.3g} {parameter.unit} from {files[i].name} alone" for i in (low, high)
            )
            yield (
                f"{parameter.name} differs between the files: {estimates}. The machine changed, or another effect "
                "is taken for this one."
            )


def _is_long_enough(model: FittedModel, path: Path) -> bool:
    """Whether the training rows of a file determine the parameters of `model` without the other files."""
    pairs = zip(model.split.train_indices, model.solution.weights, strict=True)
    rows = sum(int((weight > 0).sum()) for i, weight in pairs if model.split.recordings[i].recording.path == path)
    return rows >= MIN_ROWS_PER_PARAMETER * len(model.solution.x)


def _fit_alone(model: FittedModel, indices: Sequence[int]) -> tuple[Floats, Floats]:
    """(K,) parameters from the training rows of the recordings `indices`, and their standard errors."""
    split = model.split
    train = tuple(rows & (i in indices) for i, rows in enumerate(split.train))
    weights = tuple(weight * (i in indices) for i, weight in enumerate(split.weights))
    alone: SplitData = replace(split, train=train, weights=weights)
    solution = alone.fit(model.solution.structure, model.solution.x)
    return solution.x, FittedModel(alone, solution).standard_errors


def _between_steps(steps: Sequence[StepEntry]) -> Iterator[str]:
    """Parameters whose interval before a step and after it have nothing in common."""
    for before, after in pairwise(steps):
        for name in sorted(before.parameters.keys() & after.parameters.keys()):
            old, new = before.parameters[name], after.parameters[name]
            if "." in name and _are_apart(old, new) and _contradict(old.value, new.value):
                yield (
                    f"{name} was {old.value:.3g} {old.unit} before {after.added} was added, and is {new.value:.3g} "
                    f"{new.unit} with it: what is attributed to which of the two depends on both."
                )


def _are_apart(first: ParameterValue, second: ParameterValue) -> bool:
    """Whether both intervals are known and do not overlap."""
    if first.ci95 is None or second.ci95 is None:
        return False
    return first.ci95[1] < second.ci95[0] or second.ci95[1] < first.ci95[0]


def _contradict(first: float, second: float) -> bool:
    """Whether two values differ in sign or by more than MAX_RATIO."""
    small, large = sorted((abs(first), abs(second)))
    return first * second < 0 or large > MAX_RATIO * small
