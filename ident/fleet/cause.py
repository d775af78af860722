"""What happened in an event: the recordings before and after it, diagnosed together."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Literal

import numpy as np

from ident.basics.statistics import TINY
from ident.diagnosis.diagnosis import DiagnosisOptions
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.price import PRICE, slack
from ident.diagnosis.search.screening import Candidate
from ident.diagnosis.split.noise_floor import MIN_TORQUE_SHARE
from ident.diagnosis.unknown.residual_dependence import find_dependences
from ident.dynamics.effects.base import Effect
from ident.fleet.change_screening import ChangeScreener, as_change
from ident.fleet.discoveries import Event
from ident.fleet.places import place
from ident.fleet.recording_rows import base_fit
from ident.fleet.series import Nights, Series
from ident.fleet.settings import FleetSettings
from recordings.config import ConfigSection
from recordings.errors import BadInput
from recordings.reader import Source
from recordings.recording import Floats, Ints, Recording

RECORDINGS = 4
"""Recordings before, and after, that are diagnosed together."""
MIN_EXPLAINED = 0.85
"""Share of what the later recordings lack that an effect must explain to be named."""
MAX_FADING = 0.05
"""Share of it beyond which an effect is not named, if it is explained only by letting the effect grow or fade during
each recording: what is there since a night is there all the time."""
METHOD = 4
"""Version of this method; raised whenever the same recordings have another cause."""
_MAX_ALTERNATIVES = 4

Verdict = Literal["missing-effect", "unknown-structure"]
Origin = Literal["mechanics", "measurement", "undecided"]
Joints = tuple[int, ...]
"""Numbers of joints, from 1."""


class Cause(ConfigSection):
    """What the diagnosis of the recordings before and after an event says."""

    verdict: Verdict = "unknown-structure"
    effect: str | None = None
    """None if it is unknown."""
    joints: tuple[int, ...]
    """From 1."""
    confusable_with: tuple[str, ...] = ()
    origin: Origin = "undecided"
    """Whether the machine changed, or what measures it: drive, gain or sensor."""
    explained: float = 0.0
    """Share of what the later recordings lack, 0 to 1."""
    torque_share: float = 0.0
    """RMS of the effect in them relative to that of the torque, as far as the model cannot imitate it."""
    depends_on: tuple[str, ...] = ()
    before: tuple[str, ...]
    """Paths of the recordings."""
    after: tuple[str, ...]
    why: str


def cause(event: Event, of_robot: Nights, series: Sequence[Series], settings: FleetSettings) -> Cause:
    """Diagnose the recordings beside an `event` together; of_robot, series: all those of its robot."""
    before, after = chosen_nights(event, of_robot)
    nights = np.concatenate([before, after])
    paths = [place(of_robot.paths[night]) for night in nights]
    options = DiagnosisOptions(settings.preprocessing, settings.cutoff)
    return cause_between(
        paths[: len(before)],
        paths[len(before) :],
        _joints(event),
        options,
        lambda names: _scatter(event, series, nights, names),
    )


def cause_between(
    before: Sequence[Source],
    after: Sequence[Source],
    joints: Joints,
    options: DiagnosisOptions,
    scatter: Callable[[Sequence[str]], Floats],
    *,
    growing: bool = False,
) -> Cause:
    """Diagnose recordings `before` and `after` a change together.

    joints: those that changed, from 1.
    scatter: (recordings, K) usual deviation of the parameters of these names in each recording.
    growing: the effect may grow during the recordings after the change.
    """
    names = _names(before), _names(after)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            inputs, model = base_fit([*before, *after], options)
            usual = scatter([entry.name for entry in model.solution.structure.parameters])
            changed = [False] * len(before) + [True] * len(after)
            screener = ChangeScreener(inputs.split, model.solution, changed, usual)
            # What comes during a run is not there since a night.
            effects = {
                name: as_change(effect)
                for name, effect in inputs.effects.observable.items()
                if not (effect.mandatory or effect.axis == "time")
            }
            effects |= screener.parameter_effects()
            candidates = screener.screen(effects).candidates
            return _judged(joints, screener, candidates, effects, model, names, growing)
    except BadInput as error:
        why = f"the recordings before and after cannot be diagnosed together: {error}"
        return Cause(joints=joints, before=names[0], after=names[1], why=why)


def _names(sources: Sequence[Source]) -> tuple[str, ...]:
    return tuple(str(source.path if isinstance(source, Recording) else source) for source in sources)


def chosen_nights(event: Event, of_robot: Nights) -> tuple[Ints, Ints]:
    """Nights before and after an event: those beside a sudden one, the first and the last of one that grows."""
    first, end = event.segment
    change, motion = event.change, of_robot.motion
    before, after = np.arange(first, max(change.first, first + 1)), np.arange(min(change.last, end - 1), end)
    common = set(motion[before].tolist()) & set(motion[after].tolist())
    if common:
        before, after = (nights[np.isin(motion[nights], list(common))] for nights in (before, after))
    if change.growing:
        return before[-RECORDINGS:], after[-RECORDINGS:]
    return before[-RECORDINGS:], after[:RECORDINGS]


def _scatter(event: Event, series: Sequence[Series], nights: Ints, names: Sequence[str]) -> Floats:
    """(recordings, K) usual deviation of each parameter in these `nights`: its scatter, and what the temperature
    explains."""
    by_name = {each.name: each for each in series}
    result = np.zeros((len(nights), len(names)))
    for entry, name in enumerate(names):
        if name in by_name:
            result[:, entry] = _deviations(event, by_name[name], nights)
    return result


def _deviations(event: Event, series: Series, nights: Ints) -> Floats:
    quiet = np.arange(event.segment[0], max(event.change.first, event.segment[0] + 1))
    quiet = quiet[series.known[quiet]]
    if not len(quiet):
        return np.zeros(len(nights))
    everything = np.concatenate([quiet, nights])
    columns = _nuisance(series, everything)
    solution = np.linalg.lstsq(columns[: len(quiet)], series.value[quiet], rcond=1e-8)[0]
    explained = columns @ solution
    residual = series.value[quiet] - explained[: len(quiet)]
    freedom = max(len(quiet) - np.linalg.matrix_rank(columns[: len(quiet)]), 1)
    warmed: Floats = explained[len(quiet) :] - explained[: len(quiet)].mean()
    return np.hypot(np.sqrt(float(residual @ residual) / freedom), warmed)


def _nuisance(series: Series, nights: Ints) -> Floats:
    """(n, k) what may explain a difference between `nights`: motion, temperature, or what the whole fleet does."""
    motion = series.nights.motion[nights]
    columns = [(motion == number).astype(float) for number in np.unique(motion)]
    for value in (series.temperature[nights], series.common[nights]):
        known = np.isfinite(value)
        if known.any():
            columns += [np.where(known, value - value[known].mean(), 0.0), known.astype(float)]
    return np.column_stack(columns)


def _judged(
    joints: Joints,
    screener: ChangeScreener,
    candidates: Sequence[Candidate],
    effects: Mapping[str, Effect],
    model: FittedModel,
    names: tuple[tuple[str, ...], tuple[str, ...]],
    growing: bool,
) -> Cause:
    if not candidates:
        why = "no effect of the library shows in these recordings"
        return Cause(joints=joints, before=names[0], after=names[1], why=why)
    loss_before, rows_before = screener.loss_before()
    reachable = loss_before / rows_before * screener.row_count
    lacking = max(screener.loss - reachable, TINY)
    best = candidates[0]
    most = best.loss + slack(screener.loss, best.loss, model.split.independent_rows)
    equivalent = [candidate for candidate in candidates if candidate.loss <= most]
    chosen = min(equivalent, key=lambda candidate: (candidate.parameter_count, candidate.loss))
    explained = float(np.clip((screener.loss - chosen.loss) / lacking, 0.0, 1.0))
    alternatives = tuple(dict.fromkeys(other.term.name for other in equivalent if other is not chosen))
    origins: set[Origin] = {
        "mechanics" if effects[candidate.term.name].linear else "measurement" for candidate in equivalent
    }
    fades = not growing and _fades(screener, chosen, lacking, model.split.independent_rows)
    known = explained >= MIN_EXPLAINED and not fades
    share = np.sqrt(max(screener.loss - chosen.loss, 0.0) / screener.torque_after())
    return Cause(
        verdict="missing-effect" if known else "unknown-structure",
        effect=chosen.term.name if known else None,
        joints=tuple(joint + 1 for joint in chosen.term.joints) if known else joints,
        confusable_with=alternatives[:_MAX_ALTERNATIVES] if known else (),
        origin=origins.pop() if len(origins) == 1 and known else "undecided",
        explained=explained,
        torque_share=float(share),
        depends_on=() if known else _dependences(joints, model, len(names[0])),
        before=names[0],
        after=names[1],
        why=_reason(chosen.term.name, explained, fades),
    )


def _fades(screener: ChangeScreener, chosen: Candidate, lacking: float, independent_rows: float) -> bool:
    """Whether the effect explains clearly more if it may grow or fade during each recording."""
    chance = PRICE * chosen.parameter_count * chosen.loss / independent_rows
    return screener.fading_reduction(chosen) > max(MAX_FADING * lacking, chance)


def _dependences(joints: Joints, model: FittedModel, count_before: int) -> tuple[str, ...]:
    """Variables on which the residual of the later recordings depends: by curves, or as a vibration."""
    residuals = [
        residual if index >= count_before else np.full_like(residual, np.nan)
        for index, residual in enumerate(model.residuals)
    ]
    numbers = [joint - 1 for joint in joints]
    dependences = find_dependences(model.split, model.solution, residuals, numbers)
    if not dependences and any(_vibrates(model, joint) for joint in numbers):
        return ("frequency",)
    return tuple(sorted({variable for dependence in dependences for variable in dependence.variables}))


def _vibrates(model: FittedModel, joint: int) -> bool:
    """Whether the residual of a `joint`, from 0, has a relevant line in its spectrum."""
    line = model.noise_floor.lines[joint]
    return line is not None and line.mean_square > float(MIN_TORQUE_SHARE * model.split.torque_rms[joint]) ** 2


def _reason(name: str, explained: float, fades: bool) -> str:
    if explained < MIN_EXPLAINED:
        return f"No effect explains what is different since then; {name}, the nearest, {100 * explained:.0f} % of it"
    reason = f"{name} explains {100 * explained:.0f} % of what is different since then"
    return f"{reason}, but the difference grows or fades during each recording" if fades else reason


def _joints(event: Event) -> Joints:
    """Joints of the series that changed, the strongest first; none if only the whole robot's parameters did."""
    return tuple(dict.fromkeys(change.joint for change in event.changes if change.joint is not None))[:1]
