"""The climb by hand: fit, look what could be added, add, take away. It runs in a process of its own.

Every task is a generator of what the page shall show, the most urgent first, and says from which ladder it begins: a
process that knows this ladder goes on at once, another one climbs it again. Models, errors and gains are those of
`ident diagnose` (`ident.diagnosis.stepwise_selection`), taken one step at a time.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from weakref import WeakKeyDictionary

import numpy as np

from ident.data.samples import holds_torque
from ident.diagnosis import answer
from ident.diagnosis.diagnosis import Choices, Question, diagnose, question
from ident.diagnosis.document import labels
from ident.diagnosis.screening import Candidate
from ident.diagnosis.steps import Rung
from ident.diagnosis.stepwise_selection import Climber
from ident.dynamics import mechanisms
from ident.dynamics.effects.library import library
from ident.dynamics.structure import Composition, Term
from ident.output.figures.finding import before_after
from ident.residuals import phases
from ident.workbench import plots, pso_task, views
from ident.workbench.preview import foretaste
from ident.workbench.recording_view import BEGINNING, looks, mismatch
from ident.workbench.residual_task import failing, of_excerpts
from ident.workbench.selection_state import Climb, Step
from ident.workbench.views import Kept, Place
from recordings.errors import BadInput
from recordings.reader import read

Shown = (
    views.RecordingView
    | views.Mismatch
    | views.LadderView
    | tuple[views.Series, ...]
    | views.Choice
    | views.Signatures
    | views.Failing
    | views.Answer
    | views.Descent
    | views.Swarmed
)
Progress = Callable[[str], None]


class Engine:
    """Does the tasks of one session."""

    def __init__(
        self,
        progress: Progress,
        effect_files: Sequence[Path] = (),
        tell: Callable[[views.Descent], None] = lambda descent: None,
    ) -> None:
        """`tell`: called with what is to be shown while a task goes on."""
        self._progress, self._tell = progress, tell
        self._effect_files = tuple(effect_files)
        self._library = library(effect_files)
        self._climb: Climb | None = None
        self._candidates: dict[str, Candidate] = {}
        self._known: WeakKeyDictionary[Step, views.RungView] = WeakKeyDictionary()

    def look(self, path: Path, check: Path | None = None) -> Iterator[Shown]:
        """A recording as it is; first, whether a model of it could be judged on `check`."""
        self._progress(f"reading {path.name}")
        if check is not None:
            yield from mismatch(path, check)
        yield from looks(path)

    def fit(self, train: Path, validate: Path | None) -> Iterator[Shown]:
        """The base model, with what is true of any such machine."""
        self._climb = climb = self._begun(train, validate)
        yield from self._show(climb)

    def show(self, place: Place) -> Iterator[Shown]:
        """The ladder at `place`."""
        yield from self._show(self._at(place))

    def add(self, place: Place, name: str) -> Iterator[Shown]:
        """One effect more, everything refitted."""
        climb = self._at(place)
        if not self._candidates:  # this process has taken the place of another
            self._choice(climb)
        if name not in self._candidates:
            raise BadInput(
                f"an effect that this motion shows, with a possible sign, expected, '{name}' found; "
                "choose another card"
            )
        self._progress(f"fitting everything with {name}")
        climb.push(f"+ {name}", name, climb.climber.finder.added(climb.state, self._candidates[name]))
        yield from self._show(climb)

    def remove(self, place: Place, index: int) -> Iterator[Shown]:
        """Without the effect `index` of the present model, refitted; as a further rung, so that nothing is lost."""
        climb = self._at(place)
        if not 0 <= index < len(climb.state.terms):
            raise BadInput(f"an effect of the model expected, number {index + 1} found; look at the ladder again")
        name = climb.state.terms[index].name
        self._progress(f"fitting everything without {name}")
        climb.push(f"− {name}", None, climb.climber.without(climb.state, index))
        yield from self._show(climb)

    def diagnose(self, place: Place) -> Iterator[Shown]:
        """What `ident diagnose` says; its ladder becomes the present one."""
        climb = self._at(place)
        train, validate = climb.files
        found = diagnose([train], _given(validate), self._library, Choices(), self._progress)
        self._progress("putting it into words")
        named = {one.term.name: one for one in reversed(found.ladder.findings)}
        drawn = {name: plots.plain(before_after(found, one)) for name, one in named.items()}
        yield views.Answer(answer.document(found).as_json(), drawn)
        climb.asked = Question(found.material, climb.asked.offered, found.unobservable, found.excerpt)
        climb.climber = Climber(found.material, climb.asked.offered, self._progress)
        climb.known.clear()
        climb.go(*_steps(found.ladder.rungs))
        climb.diagnosed = climb.state
        yield from self._show(climb)

    def swarm(self, train: Path, validate: Path | None, chosen: views.Chosen) -> Iterator[Shown]:
        """The parameters by the paper's swarm, as `ident fit` finds them."""
        self._progress("reading and preparing the recordings; then the swarm")
        yield pso_task.found(train, validate, chosen, self._effect_files, self._tell)

    def _at(self, place: Place) -> Climb:
        """The climb, at the ladder of `place`."""
        climb = self._climb
        if climb is None or climb.files != (place.train, place.validate):
            climb = self._begun(place.train, place.validate)
        if climb.kept != place.rungs:
            self._candidates = {}
            climb.go(*self._climbed(climb, place.rungs))
        self._climb = climb
        return climb

    def _begun(self, train: Path, validate: Path | None) -> Climb:
        self._progress("reading and preparing the recordings")
        asked = question([train], _given(validate), self._library, Choices())
        climber = Climber(asked.material, asked.offered, self._progress)
        self._progress("fitting the base model")
        state, rungs = climber.begin(*asked.beginning(self._library))
        climb = Climb((train, validate), asked, climber)
        climb.go(*_steps(rungs))
        if climb.state is not state:  # what is true anyway is in the model, be it seen or not
            name = state.terms[-1].name
            climb.push(f"+ {name}", name, state)
        self._candidates = {}
        return climb

    def _climbed(self, climb: Climb, rungs: tuple[Kept, ...]) -> Iterator[Step]:
        """The ladder of these `rungs`, fitted where it is not known."""
        bare = replace(climb.state.solution.composition, terms=())
        before: Step | None = None
        for number, (label, terms, x) in enumerate(rungs, start=1):
            step = climb.known.get(rungs[:number])
            if step is None:
                composition = replace(bare, terms=tuple(self._term(*term) for term in terms))
                state = climb.climber.finder.solved(composition, np.array(x))
                gain = climb.climber.gain(before.rung.state, state) if before else None
                step = Step(label, Rung(terms[-1][0] if label.startswith("+") else None, state, gain))
            yield step
            before = step

    def _term(self, name: str, joints: tuple[int, ...]) -> Term:
        return Term(name, self._library[name], tuple(joint - 1 for joint in joints))

    def _show(self, climb: Climb) -> Iterator[Shown]:
        self._candidates = {}
        yield self._ladder(climb)
        yield _series(climb)
        self._progress("looking at every effect of the library")
        yield self._choice(climb)
        self._progress("drawing what each would take away")
        yield foretaste(climb.asked.material, climb.state, self._candidates, climb.climber.floor(climb.state))
        self._progress("looking where the model fails")
        if climb.asked.excerpt is None:
            yield self._failing(climb)
        else:
            yield of_excerpts(climb.asked.material, climb.state)

    def whole(self, place: Place, bandwidth: float) -> Iterator[Shown]:
        """The model on top of `place`, fitted to all of long recordings at its `bandwidth` [Hz].

        It needs nothing of the climb, so that a process that remembers none has the memory for it.
        """
        self._progress("fitting to the whole recording")
        rig, (_, terms, x) = read(place.train, BEGINNING).rig, place.rungs[-1]
        composition = Composition(mechanisms.create(rig), rig, tuple(self._term(*term) for term in terms))
        yield failing((place.train, place.validate), (composition, np.array(x)), bandwidth, self._library)

    def _failing(self, climb: Climb) -> views.Failing:
        solution = climb.state.solution
        bandwidth = climb.asked.material.datasets[0].bandwidth
        return failing(climb.files, (solution.composition, solution.x), bandwidth, self._library)

    def _ladder(self, climb: Climb) -> views.LadderView:
        material, (train, validate) = climb.asked.material, climb.files
        recording = material.datasets[0].recording
        return views.LadderView(
            train=train.name,
            validate=validate.name if validate else None,
            rungs=tuple(self._rung(climb, step) for step in climb.steps),
            noise_rms=tuple(climb.climber.floor(climb.state).rms.tolist()),
            torque_rms=tuple(material.torque_rms.tolist()),
            joints=recording.rig.joint_names,
            units=recording.rig.effort_units,
            position_units=recording.rig.position_units,
            relative=recording.rig.torque.gain_source == "assumed" and not holds_torque(recording),
            simulated=any(data.recording.run.simulated for data in material.datasets),
            bandwidth=material.datasets[0].bandwidth,
            held_out=answer.held_out(material),
            excerpt=climb.asked.excerpt,
            always=tuple(name for name, effect in self._library.items() if effect.always_true),
            diagnosed=climb.state is climb.diagnosed,
        )

    def _rung(self, climb: Climb, step: Step) -> views.RungView:
        if step not in self._known:
            gain, (label, terms, x) = step.rung.gain, step.kept
            self._known[step] = views.RungView(
                label=label,
                entry=answer.rung_entry(climb.asked.material, step.rung),
                terms=terms,
                x=x,
                gain=gain.share if gain else None,
                gain_ci95=gain.interval if gain else None,
            )
        return self._known[step]

    def _choice(self, climb: Climb) -> views.Choice:
        candidates, unseen, gains = climb.climber.finder.look(climb.state)
        self._candidates = {}
        for one in candidates:
            self._candidates.setdefault(one.term.name, one)  # of several lines of a spectrum the best
        shown = [views.Candidate(name, _joints(one.term), gains[name]) for name, one in self._candidates.items()]
        return views.Choice(tuple(shown), tuple(unseen), dict(climb.asked.unobservable))


def _given(path: Path | None) -> list[Path]:
    return [path] if path else []


def _steps(rungs: Sequence[Rung]) -> tuple[Step, ...]:
    names = labels([[term.name for term in rung.state.terms] for rung in rungs])
    return tuple(Step(name, rung) for name, rung in zip(names, rungs, strict=True))


def _joints(term: Term) -> tuple[int, ...]:
    return () if term.effect.whole_robot else tuple(joint + 1 for joint in term.joints)


def _series(climb: Climb) -> tuple[views.Series, ...]:
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
            phase=phases.phases(data),
            cycle=data.repeat + 1,
            counted=seen | held,
        )
        for data, residual, seen, held in zip(material.datasets, residuals, material.seen, material.held, strict=True)
    )
