"""What happened in an event: the recordings before and after it, diagnosed together."""

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from ident.basics.statistics import TINY
from ident.diagnosis.diagnosis import DiagnosisOptions, prepare_inputs
from ident.diagnosis.judge.equivalence import EQUIVALENT_SHARE
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.price import PRICE
from ident.diagnosis.search.screening import Candidate
from ident.diagnosis.search.search import Search
from ident.diagnosis.split.noise_floor import MIN_TORQUE_SHARE
from ident.diagnosis.unknown.residual_dependence import find_dependences
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.library import library
from ident.fleet.change_screening import ChangeScreener, as_change
from ident.fleet.discoveries import Event, nuisance
from ident.fleet.series import Series
from ident.fleet.settings import FleetSettings
from recordings.config import ConfigSection
from recordings.errors import BadInput
from recordings.recording import Floats, Ints

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


class Cause(ConfigSection):
    """What the diagnosis of the recordings before and after an event says."""

    verdict: Verdict
    effect: str | None
    """None if it is unknown."""
    joints: tuple[int, ...]
    """From 1."""
    confusable_with: tuple[str, ...]
    origin: Origin
    """Whether the machine changed, or what measures it: drive, gain or sensor."""
    explained: float
    """Share of what the later recordings lack, 0 to 1."""
    torque_share: float
    """RMS of the effect in them relative to that of the torque, as far as the model cannot imitate it."""
    depends_on: tuple[str, ...]
    before: tuple[str, ...]
    """Paths of the recordings."""
    after: tuple[str, ...]
    why: str


def cause(event: Event, series: Sequence[Series], settings: FleetSettings) -> Cause:
    """Diagnose the recordings beside an `event` together; series: all those of its robot."""
    before, after = chosen_nights(event)
    nights = np.concatenate([before, after])
    paths = [Path(event.nights.paths[night]) for night in nights]
    names = tuple(map(str, paths[: len(before)])), tuple(map(str, paths[len(before) :]))
    options = DiagnosisOptions(settings.preprocessing, settings.cutoff)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            inputs = prepare_inputs(paths, [], library([]), options)
            selector = Search(inputs.split, inputs.effects.observable, lambda text: None)
            model, _ = selector.start(*inputs.initial_model(library([])))
            scatter = _scatter(event, series, nights, [entry.name for entry in model.solution.structure.parameters])
            screener = ChangeScreener(inputs.split, model.solution, [night in after for night in nights], scatter)
            # What comes during a run is not there since a night.
            effects = {
                name: as_change(effect)
                for name, effect in inputs.effects.observable.items()
                if not (effect.mandatory or effect.axis == "time")
            }
            effects |= screener.parameter_effects()
            candidates, _ = screener.screen(effects)
            return _judged(event, screener, candidates, effects, model, names)
    except BadInput as error:
        return _unexplained(event, names, f"the recordings before and after cannot be diagnosed together: {error}")


def chosen_nights(event: Event) -> tuple[Ints, Ints]:
    """Nights before and after an event: those beside a sudden one, the first and the last of one that grows."""
    first, end = event.segment
    change, motion = event.change, event.nights.motion
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
    columns = nuisance(series, everything)
    solution = np.linalg.lstsq(columns[: len(quiet)], series.value[quiet], rcond=1e-8)[0]
    explained = columns @ solution
    residual = series.value[quiet] - explained[: len(quiet)]
    freedom = max(len(quiet) - np.linalg.matrix_rank(columns[: len(quiet)]), 1)
    warmed: Floats = explained[len(quiet) :] - explained[: len(quiet)].mean()
    return np.hypot(np.sqrt(float(residual @ residual) / freedom), warmed)


def _judged(
    event: Event,
    screener: ChangeScreener,
    candidates: Sequence[Candidate],
    effects: Mapping[str, Effect],
    model: FittedModel,
    names: tuple[tuple[str, ...], tuple[str, ...]],
) -> Cause:
    if not candidates:
        return _unexplained(event, names, "no effect of the library shows in these recordings")
    loss_before, rows_before = screener.loss_before()
    reachable = loss_before / rows_before * screener.row_count
    lacking = max(screener.loss - reachable, TINY)
    best = candidates[0]
    slack = EQUIVALENT_SHARE * (screener.loss - best.loss)
    slack = max(slack, PRICE * best.loss / model.split.independent_rows)
    equivalent = [candidate for candidate in candidates if candidate.loss - best.loss <= slack]
    chosen = min(equivalent, key=lambda candidate: (candidate.parameter_count, candidate.loss))
    explained = float(np.clip((screener.loss - chosen.loss) / lacking, 0.0, 1.0))
    alternatives = tuple(dict.fromkeys(other.term.name for other in equivalent if other is not chosen))
    origins: set[Origin] = {
        "mechanics" if effects[candidate.term.name].linear else "measurement" for candidate in equivalent
    }
    fades = _fades(screener, chosen, lacking, model.split.independent_rows)
    known = explained >= MIN_EXPLAINED and not fades
    share = np.sqrt(max(screener.loss - chosen.loss, 0.0) / screener.torque_after())
    return Cause(
        verdict="missing-effect" if known else "unknown-structure",
        effect=chosen.term.name if known else None,
        joints=tuple(joint + 1 for joint in chosen.term.joints) if known else _joints(event),
        confusable_with=alternatives[:_MAX_ALTERNATIVES] if known else (),
        origin=origins.pop() if len(origins) == 1 and known else "undecided",
        explained=explained,
        torque_share=float(share),
        depends_on=() if known else _dependences(event, model, len(names[0])),
        before=names[0],
        after=names[1],
        why=_reason(chosen.term.name, explained, fades),
    )


def _fades(screener: ChangeScreener, chosen: Candidate, lacking: float, independent_rows: float) -> bool:
    """Whether the effect explains clearly more if it may grow or fade during each recording."""
    chance = PRICE * chosen.parameter_count * chosen.loss / independent_rows
    return screener.fading_reduction(chosen) > max(MAX_FADING * lacking, chance)


def _dependences(event: Event, model: FittedModel, count_before: int) -> tuple[str, ...]:
    """Variables on which the residual of the later recordings depends: by curves, or as a vibration."""
    residuals = [
        residual if index >= count_before else np.full_like(residual, np.nan)
        for index, residual in enumerate(model.residuals)
    ]
    joints = [joint - 1 for joint in _joints(event)]
    dependences = find_dependences(model.split, model.solution, residuals, joints)
    if not dependences and any(_vibrates(model, joint) for joint in joints):
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


def _unexplained(event: Event, names: tuple[tuple[str, ...], tuple[str, ...]], why: str) -> Cause:
    return Cause(
        verdict="unknown-structure",
        effect=None,
        joints=_joints(event),
        confusable_with=(),
        origin="undecided",
        explained=0.0,
        torque_share=0.0,
        depends_on=(),
        before=names[0],
        after=names[1],
        why=why,
    )


def _joints(event: Event) -> tuple[int, ...]:
    """Joints of the series that changed, the strongest first; none if only the whole robot's parameters did."""
    return tuple(dict.fromkeys(change.series.joint for change in event.changes if change.series.joint is not None))[
        :1
    ]
