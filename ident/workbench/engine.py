"""The climb by hand: fit, look what could be added, add, take away, undo. It runs in a process of its own.

Every task is a generator of what the page shall show, the most urgent first. Models, errors and gains are those of
`ident diagnose` (`ident.diagnose.ladder`), taken one step at a time.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ident import effects, where
from ident.composition import Term
from ident.diagnose import answer
from ident.diagnose.diagnosis import Choices, Question, diagnose, question
from ident.diagnose.ladder import Climber
from ident.diagnose.rungs import Rung, State
from ident.diagnose.screen import Candidate
from ident.figures.finding import before_after
from ident.samples import holds_torque
from ident.workbench import plots, views
from ident.workbench.failing import failing
from ident.workbench.look import looks
from recordings.errors import BadInput

Shown = (
    views.RecordingView | views.LadderView | tuple[views.Series, ...] | views.Choice | views.Failing | views.Answer
)
Progress = Callable[[str], None]

_MOST_UNDONE = 50


Kept = tuple[str, tuple[tuple[str, tuple[int, ...]], ...], tuple[float, ...]]
"""A rung by its label, its effects with their joints from 1, and all its parameters."""


@dataclass(frozen=True, eq=False)
class _Step:
    """A rung, and what was done to get there."""

    label: str
    rung: Rung


@dataclass(eq=False)
class _Climb:
    """Recordings, and the ladders so far: the last is the present one, the others are there to go back to."""

    files: tuple[Path, Path | None]
    asked: Question
    climber: Climber
    ladders: list[tuple[_Step, ...]]
    diagnosed: State | None = None
    """The model that the full diagnosis ended with."""

    @property
    def state(self) -> State:
        return self.ladders[-1][-1].rung.state

    def stepped(self, label: str, added: str | None, state: State) -> _Step:
        """The step from the present state to `state`."""
        return _Step(label, Rung(added, state, self.climber.gain(self.state, state)))

    def push(self, *steps: _Step) -> None:
        """The present ladder with further steps."""
        self.ladders.append((*self.ladders[-1], *steps))
        del self.ladders[:-_MOST_UNDONE]


class Engine:
    """Does the tasks of one session."""

    def __init__(self, progress: Progress, effect_files: Sequence[Path] = ()) -> None:
        self._progress = progress
        self._library = effects.library(effect_files)
        self._climb: _Climb | None = None
        self._candidates: dict[str, Candidate] = {}
        self._known: dict[_Step, views.RungView] = {}

    def look(self, path: Path) -> Iterator[Shown]:
        """A recording as it is."""
        self._progress(f"reading {path.name}")
        yield from looks(path)

    def fit(self, train: Path, validate: Path | None) -> Iterator[Shown]:
        """The base model, with what is true of any such machine."""
        self._progress("reading and preparing the recordings")
        asked = question([train], validate, self._library, Choices())
        climber = Climber(asked.material, asked.offered, self._progress)
        self._progress("fitting the base model")
        state, rungs = climber.begin(*asked.beginning(self._library))
        climb = _Climb((train, validate), asked, climber, [_steps(rungs)])
        if climb.state is not state:  # what is true anyway is in the model, be it seen or not
            name = state.terms[-1].name
            climb.ladders = [(*climb.ladders[-1], climb.stepped(f"+ {name}", name, state))]
        self._climb = climb
        yield from self._show(climb)

    def add(self, name: str) -> Iterator[Shown]:
        """One effect more, everything refitted."""
        climb = self._climbing()
        if not self._candidates:  # this process has taken the place of another
            self._choice(climb)
        if name not in self._candidates:
            raise BadInput(f"an effect that this motion shows expected, '{name}' found; choose another card")
        self._progress(f"fitting everything with {name}")
        climb.push(climb.stepped(f"+ {name}", name, climb.climber.finder.added(climb.state, self._candidates[name])))
        yield from self._show(climb)

    def remove(self, index: int) -> Iterator[Shown]:
        """Without the effect `index` of the present model, refitted; as a further rung, so that nothing is lost."""
        climb = self._climbing()
        if not 0 <= index < len(climb.state.terms):
            raise BadInput(f"an effect of the model expected, number {index + 1} found; look at the ladder again")
        name = climb.state.terms[index].name
        self._progress(f"fitting everything without {name}")
        climb.push(climb.stepped(f"− {name}", None, climb.climber.without(climb.state, index)))
        yield from self._show(climb)

    def undo(self) -> Iterator[Shown]:
        """Back to the ladder before the last change."""
        climb = self._climbing()
        if len(climb.ladders) > 1:
            climb.ladders.pop()
        yield from self._show(climb)

    def diagnose(self) -> Iterator[Shown]:
        """What `ident diagnose` says; its ladder becomes the present one."""
        climb = self._climbing()
        train, validate = climb.files
        found = diagnose([train], validate, self._library, Choices(), self._progress)
        self._progress("putting it into words")
        named = {one.term.name: one for one in reversed(found.ladder.findings)}
        drawn = {name: plots.plain(before_after(found, one)) for name, one in named.items()}
        yield views.Answer(answer.document(found).as_json(), drawn)
        ladder = found.ladder.rungs
        climb.asked = Question(found.material, climb.asked.offered, found.unobservable, found.excerpt)
        climb.climber = Climber(found.material, climb.asked.offered, self._progress)
        climb.ladders.append(_steps(ladder))
        climb.diagnosed = ladder[-1].state
        yield from self._show(climb)

    def restore(self, train: Path, validate: Path | None, kept: Sequence[Kept]) -> Iterator[Shown]:
        """The ladder as it was before this process took the place of another."""
        next(self.fit(train, validate))
        climb = self._climbing()
        bare = climb.ladders[-1][0].rung.state.solution.composition
        steps: list[_Step] = []
        for label, terms, x in kept:
            composition = replace(bare, terms=tuple(self._term(*term) for term in terms))
            state = climb.climber.finder.solved(composition, np.array(x))
            gain = climb.climber.gain(steps[-1].rung.state, state) if steps else None
            steps.append(_Step(label, Rung(label.removeprefix("+ ") if steps else None, state, gain)))
        climb.ladders = [tuple(steps)]
        yield from self._show(climb)

    def _term(self, name: str, joints: tuple[int, ...]) -> Term:
        return Term(name, self._library[name], tuple(joint - 1 for joint in joints))

    def _climbing(self) -> _Climb:
        if self._climb is None:
            raise BadInput("a fitted base model expected, none found; press Fit first")
        return self._climb

    def _show(self, climb: _Climb) -> Iterator[Shown]:
        self._candidates = {}
        yield self._ladder(climb)
        yield _series(climb)
        self._progress("looking at every effect of the library")
        yield self._choice(climb)
        self._progress("looking where the model fails")
        solution = climb.state.solution
        bandwidth = climb.asked.material.datasets[0].bandwidth
        yield failing(climb.files, (solution.composition, solution.x), bandwidth, self._library)

    def _ladder(self, climb: _Climb) -> views.LadderView:
        material, (train, validate) = climb.asked.material, climb.files
        recording = material.datasets[0].recording
        return views.LadderView(
            train=train.name,
            validate=validate.name if validate else None,
            rungs=tuple(self._rung(climb, step) for step in climb.ladders[-1]),
            noise_rms=tuple(climb.climber.floor(climb.state).rms.tolist()),
            torque_rms=tuple(material.torque_rms.tolist()),
            joints=recording.rig.joint_names,
            units=recording.rig.effort_units,
            relative=recording.rig.torque.gain_source == "assumed" and not holds_torque(recording),
            simulated=any(data.recording.run.simulated for data in material.datasets),
            bandwidth=material.datasets[0].bandwidth,
            held_out=answer.held_out(material),
            excerpt=climb.asked.excerpt,
            can_undo=len(climb.ladders) > 1,
            always=tuple(name for name, effect in self._library.items() if effect.always_true),
            diagnosed=climb.state is climb.diagnosed,
        )

    def _rung(self, climb: _Climb, step: _Step) -> views.RungView:
        if step not in self._known:
            state, gain = step.rung.state, step.rung.gain
            self._known[step] = views.RungView(
                label=step.label,
                entry=answer.rung_entry(climb.asked.material, step.rung),
                terms=tuple((term.name, tuple(joint + 1 for joint in term.joints)) for term in state.terms),
                x=tuple(state.solution.x.tolist()),
                gain=gain.share if gain else None,
                gain_ci95=gain.interval if gain else None,
            )
        return self._known[step]

    def _choice(self, climb: _Climb) -> views.Choice:
        candidates, unseen, gains = climb.climber.finder.look(climb.state)
        self._candidates = {}
        for one in candidates:
            self._candidates.setdefault(one.term.name, one)  # of several lines of a spectrum the best
        shown = [views.Candidate(name, _joints(one.term), gains[name]) for name, one in self._candidates.items()]
        return views.Choice(tuple(shown), tuple(unseen), dict(climb.asked.unobservable))


def _steps(rungs: Sequence[Rung]) -> tuple[_Step, ...]:
    return tuple(_Step(f"+ {rung.added}" if rung.added else "base model", rung) for rung in rungs)


def _joints(term: Term) -> tuple[int, ...]:
    return () if term.effect.whole_robot else tuple(joint + 1 for joint in term.joints)


def _series(climb: _Climb) -> tuple[views.Series, ...]:
    material, residuals = climb.asked.material, climb.state.residuals
    return tuple(
        views.Series(
            name=data.recording.path.name,
            held_out=bool(held.any()) and not seen.any(),
            time=data.time,
            measured=data.torque,
            computed=data.torque - residual,
            velocity=data.motion.velocity,
            position=data.motion.position,
            phase=where.phases(data),
            cycle=data.repeat + 1,
            counted=seen | held,
        )
        for data, residual, seen, held in zip(material.datasets, residuals, material.seen, material.held, strict=True)
    )
