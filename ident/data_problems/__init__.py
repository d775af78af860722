"""Data problems: what cannot be right about recordings. One kind is one module, found by its name.

Each module of `kinds` has a function `find(facts)` that returns the problem, or None. `recordings.data_problems` has
those that need no model.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass

from ident.basics import plugins
from ident.data.prepared_recording import PreparedRecording, prepare
from ident.data_problems import angle_scale
from ident.data_problems.facts import Facts
from ident.data_problems.implausible import ImplausibleData, ProblemsDocument
from recordings import data_problems
from recordings.data_problems import DataProblem
from recordings.errors import BadInput
from recordings.outliers import without_outliers
from recordings.recording import IMPORTED, Recording

_KINDS = "ident.data_problems.kinds"
# What is to be corrected, beside the recording, where this program has recorded it.
_OF_OUR_RIG = {
    "joint-order": "In the rig file, correct the order of [[drives]].",
    "angle-unit": "In the rig file, correct counts_per_turn and gear of [[drives]].",
    "gear-ratio": "In the rig file, correct gear of [[drives]].",
    "torque-unit": "In the rig file, correct rated_torque of [[drives]], torque.per_ampere or torque.gain.",
    "torque-sign": "Turn the polarity of the torque in the drive: `sign` of [[drives]] turns the position, too.",
}
Preparation = Callable[[Sequence[Recording]], Sequence[Sequence[PreparedRecording]]]
"""Prepares recordings, each as one or several excerpts."""


@dataclass(frozen=True, eq=False)
class Examined:
    """A recording that was prepared."""

    excerpts: Sequence[PreparedRecording]
    problems: tuple[DataProblem, ...]
    """Those that do not keep from using it."""


def examined(
    recordings: Sequence[Recording], preparation: Preparation, accept: Collection[str] = ()
) -> list[Examined]:
    """Prepare `recordings` without spikes, if nothing is wrong with them that blocks.

    accept: kinds of problems that do not keep from using them.

    Raises:
        ImplausibleData: they cannot be what they are said to be.
        BadInput: they cannot be prepared, or a kind does not exist.
    """
    check_kinds(accept)
    of_recordings = [list(_of_recording(recording)) for recording in recordings]
    _check(recordings, of_recordings, accept)
    prepared = preparation([without_outliers(recording) for recording in recordings])
    for excerpts, found in zip(prepared, of_recordings, strict=True):
        facts = Facts(excerpts)
        found.extend(filter(None, (plugins.load(_KINDS, name).find(facts) for name in plugins.names(_KINDS))))
    _check(recordings, of_recordings, accept)
    return [Examined(excerpts, tuple(found)) for excerpts, found in zip(prepared, of_recordings, strict=True)]


def check_data(recordings: Sequence[Recording]) -> ProblemsDocument:
    """List what cannot be right about `recordings`.

    Raises:
        BadInput: one of them cannot be used, but no problem is the reason.
    """
    try:
        usable = examined(recordings, lambda each: [[prepare(recording, "parallel", None)] for recording in each])
        found = listed(recordings, [each.problems for each in usable])
    except ImplausibleData as error:
        found = error.problems
    return ProblemsDocument(schema=2, data_problems=found, recordings=tuple(each.path.name for each in recordings))


def check_kinds(names: Iterable[str]) -> None:
    """Raise BadInput if there is no kind of data problem of one of these `names`."""
    if unknown := [name for name in names if name not in kind_names()]:
        raise BadInput(
            f"a kind of data problem expected ({', '.join(kind_names())}), '{unknown[0]}' found; choose one"
        )


def kind_names() -> tuple[str, ...]:
    """All kinds, in alphabetical order."""
    modules = [*plugins.names(_KINDS), *plugins.names("recordings.data_problems.kinds"), *angle_scale.KINDS]
    return tuple(sorted(name.replace("_", "-") for name in modules))


def listed(
    recordings: Sequence[Recording], of_recordings: Sequence[Sequence[DataProblem]]
) -> tuple[DataProblem, ...]:
    """The problems of all `recordings`, with the name of the file where there are several."""
    pairs = [
        (each, _with_key(each, problem))
        for each, found in zip(recordings, of_recordings, strict=True)
        for problem in found
    ]
    if len(recordings) == 1:
        return tuple(problem for _, problem in pairs)
    return tuple(problem.model_copy(update={"why": f"{each.path.name}: {problem.why}"}) for each, problem in pairs)


def _with_key(recording: Recording, problem: DataProblem) -> DataProblem:
    ours = recording.rig.drives and recording.run.trajectory != IMPORTED
    key = _OF_OUR_RIG.get(problem.kind) if ours else None
    return problem.model_copy(update={"why": f"{problem.why} {key}"}) if key else problem


def _of_recording(recording: Recording) -> Iterator[DataProblem]:
    found = list(data_problems.problems(recording))
    yield from found
    if not any(problem.blocks for problem in found) and (scale := angle_scale.find(recording)):
        yield scale


def _check(
    recordings: Sequence[Recording], of_recordings: Sequence[Sequence[DataProblem]], accept: Collection[str]
) -> None:
    found = listed(recordings, of_recordings)
    if any(problem.blocks and problem.kind not in accept for problem in found):
        raise ImplausibleData([recording.path.name for recording in recordings], found)
