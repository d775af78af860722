"""Data problems: what cannot be right about recordings. One kind is one module, found by its name.

Each module of `kinds` has a function `find(facts)` that returns the problem, or None. `recordings.data_problems` has
those that need no model.
"""

from collections.abc import Callable, Iterator, Sequence

from ident import plugins
from ident.data.prepared_recording import PreparedRecording
from ident.data_problems import angle_unit
from ident.data_problems.facts import Facts
from recordings import data_problems
from recordings.data_problems import DataProblem
from recordings.data_problems.kinds.spikes import without_spikes
from recordings.errors import BadInput
from recordings.recording import Recording

_KINDS = "ident.data_problems.kinds"
Prepare = Callable[[Sequence[Recording]], Sequence[Sequence[PreparedRecording]]]
"""Prepares recordings, each as one or several excerpts."""


def prepared_with_problems(
    recordings: Sequence[Recording], prepare: Prepare
) -> tuple[Sequence[Sequence[PreparedRecording]], tuple[DataProblem, ...]]:
    """Prepare `recordings` without spikes, and list what cannot be right about them.

    Raises:
        BadInput: they cannot be prepared; with the problem that explains it, where there is one.
    """
    several = len(recordings) > 1
    found = [_named(recording, problem, several) for recording in recordings for problem in _of_recording(recording)]
    try:
        prepared = prepare([without_spikes(recording) for recording in recordings])
    except BadInput:
        reasons = [f"{problem.kind}: {problem.why} {problem.remedy}" for problem in found if problem.blocks]
        if not reasons:
            raise
        names = ", ".join(recording.path.name for recording in recordings)
        raise BadInput("\n".join([f"{names}: data that can be right expected, found", *reasons])) from None
    if not _blocks(found):  # a fit would only blur what is known
        found += [
            _named(excerpts[0].recording, problem, several)
            for excerpts in prepared
            for problem in problems(Facts(excerpts))
        ]
    return prepared, tuple(found)


def problems(facts: Facts) -> Iterator[DataProblem]:
    """Yield the problems of a recording that take a model, by kind in alphabetical order."""
    for name in plugins.names(_KINDS):
        found = plugins.load(_KINDS, name).find(facts)
        if found is not None:
            yield found


def _of_recording(recording: Recording) -> list[DataProblem]:
    found = list(data_problems.problems(recording))
    if _blocks(found) or (unit := angle_unit.find(recording)) is None:
        return found
    return [*found, unit]


def _named(recording: Recording, problem: DataProblem, several: bool) -> DataProblem:
    """The `problem`, with the name of the file where there are several."""
    return problem.model_copy(update={"why": f"{recording.path.name}: {problem.why}"}) if several else problem


def _blocks(found: Sequence[DataProblem]) -> bool:
    return any(problem.blocks for problem in found)
