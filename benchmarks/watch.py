"""`python -m benchmarks.watch --folder FOLDER [--runs N]`: how soon and how falsely `ident watch` raises its alarm.

A period of a motion of the foreign plant is computed without and with one effect of the library and repeated with new
noise: 300 runs with nothing, 50 of them of a robot that warms up, in its healthy recordings, too; 100 with a step of
3 % at a random instant; 20 that grow to 3 %. Cases are drawn from SEED, by default from the commit. Each result is a
line of a file in FOLDER, so that a run can be continued.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal

import click
import numpy as np

import ident
from benchmarks.hidden_effects import sources, work
from benchmarks.hidden_effects.cases import drawn_effects
from drivers.simulated.effect import HiddenEffect
from drivers.simulated.hidden import draw_effect
from ident.basics import slicing
from ident.watch.watching import Watch
from recordings.recording import Floats, Recording
from tests.foreign import reference_motion, robots
from tests.foreign.plant import Plant, Reported, name
from tests.foreign.sizing import EffectSizer

Kind = Literal["nothing", "warming", "step", "growing"]
PLAN: dict[Kind, int] = {"nothing": 250, "warming": 50, "step": 100, "growing": 20}
RATE, BITS, VOLTS = 200.0, 18, 0.01
"""[Hz], resolution of the encoders [bit], noise of the voltage [V]."""
MINUTES = {"nothing": 20.0, "warming": 20.0, "step": 5.0, "growing": 9.0}
SIZE, GROWTH, PATIENCE = 0.03, 300.0, 60.0
"""Of an effect; duration of its growth, and time until an alarm counts as late [s]."""
WARMING, WARM_AFTER = -0.05, 600.0
"""Change of friction, and duration of it [s]."""
HEALTHY = {"nothing": 60.0, "warming": 600.0, "step": 60.0, "growing": 60.0}
"""Duration of the healthy recordings [s]."""
WANDER = (0.2924, 1e-4)
"""Frequency, relative to the cycle's, and amplitude of a slow wander [rad]: no machine repeats the same encoder
counts cycle by cycle."""
PIECE = 500
"""Samples that come at once."""


@dataclass(frozen=True)
class Outcome:
    """One run."""

    kind: Kind
    effect: str | None
    joints: Sequence[int]
    onset: float | None
    """When the effect is as large as it gets [s]."""
    begins: float | None
    alarm: float | None
    """Time of the alarm's line [s]."""
    named: Sequence[str] = ()
    named_joints: Sequence[int] = ()


@dataclass(frozen=True, eq=False)
class Robot:
    """One period of a robot's motion, without and with its effect."""

    plant: Plant
    bare: Reported
    changed: Reported

    @property
    def period(self) -> slice:
        """Samples of the second cycle."""
        reference = self.plant.reference
        return slice(*(np.flatnonzero(reference.repeat[:: reference.per_sample] == 1)[[0, -1]] + [0, 1]))

    def recording(self, share: Floats, warmth: Floats, rng: np.random.Generator) -> Recording:
        """Repeat the period; share: (n,) of the effect; warmth: (n,) change of friction."""
        rig, friction = self.plant.robot.rig, self.plant.robot.friction
        gain = np.array(rig.torque.gain)
        n = len(share)
        length = self.period.stop - self.period.start
        rows = self.period.start + np.arange(n) % length
        bare, changed = (gain * each.voltage * np.abs(each.voltage) for each in (self.bare, self.changed))
        velocity = self.bare.velocity[rows]
        rubbing = np.array(friction.coulomb) * np.sign(velocity) + np.array(friction.viscous) * velocity
        part = share[:, None]
        torque = (1 - part) * bare[rows] + part * changed[rows] + warmth[:, None] * rubbing
        volts = np.sign(torque) * np.sqrt(np.abs(torque) / gain) + rng.normal(0.0, VOLTS, torque.shape)
        position = (1 - part) * self.bare.position[rows] + part * self.changed.position[rows]
        wander = WANDER[1] * np.sin(2 * np.pi * WANDER[0] / length * np.arange(n)[:, None] + np.arange(3))
        counts = np.array([drive.counts_per_radian for drive in rig.drives])
        time, cycle = np.arange(n) / rig.rate, np.arange(n) // length
        seen = np.rint((position + wander) * counts) / counts
        return Recording.from_arrays(time, seen, voltage=volts, cycle=cycle, rig=rig)


@dataclass(frozen=True)
class WatchedCase:
    """What is drawn of one run."""

    kind: Kind
    number: int

    @property
    def name(self) -> str:
        """Of the stored result."""
        return f"{self.kind}-{self.number}"


def cases() -> list[WatchedCase]:
    """All runs, the kinds mixed, so that the first ones are of all kinds."""
    numbered = [(number / count, kind, number) for kind, count in PLAN.items() for number in range(count)]
    return [WatchedCase(kind, number) for _, kind, number in sorted(numbered)]


def line_of(case: WatchedCase, seed: int) -> dict[str, Any]:
    """The line to store of a run."""
    rng = np.random.default_rng([seed, list(PLAN).index(case.kind), case.number])
    return {"case": case.name, "engine": str(seed), "outcome": asdict(run(case.kind, rng))}


def robot_of(kind: Kind, rng: np.random.Generator) -> tuple[Robot, HiddenEffect | None]:
    """Draw a robot, its motion, and an effect that can have its size on it."""
    robot = robots.draw("default", rng, rate=RATE, bits=BITS, reports_command=False)
    plant = Plant(robot, reference_motion.draw(robot.rig.geometry, "fourier", rng=rng, rate=RATE, seconds=12.0))
    bare = plant.report()
    if kind in ("nothing", "warming"):
        return Robot(plant, bare, bare), None
    sizer, names = EffectSizer(plant), [each for each in drawn_effects() if each != "thermal_drift"]
    while True:
        scaled = sizer.nearest(draw_effect(rng, names), SIZE)
        if scaled and abs(scaled[1] / SIZE - 1) < 0.1:
            return Robot(plant, bare, plant.report((scaled[0],))), scaled[0]


def run(kind: Kind, rng: np.random.Generator) -> Outcome:
    """Fit, watch, and say what came of it."""
    robot, effect = robot_of(kind, rng)
    begins, onset = None, None
    n, healthy = (np.arange(round(seconds * RATE)) / RATE for seconds in (60 * MINUTES[kind], HEALTHY[kind]))
    share = np.zeros(len(n))
    if effect is not None:
        begins = float(rng.uniform(60, 180))
        onset = begins if kind == "step" else begins + GROWTH
        share = np.where(n >= begins, 1.0, 0.0) if kind == "step" else np.clip((n - begins) / GROWTH, 0, 1)
    still = np.zeros_like(n[: round(40 * RATE)])
    train, test = (robot.recording(still, still, rng) for _ in range(2))
    warm = [WARMING * np.minimum(time / WARM_AFTER, 1) * (kind == "warming") for time in (healthy, n)]
    known = robot.recording(np.zeros(len(healthy)), warm[0], rng)
    model = ident.fit(train, validate=test, method="ls")
    watch = Watch(model, [known])
    lines = watch.lines(pieces(robot.recording(share, warm[1], rng)))
    alarm = next((line for line in lines if line["alarm"]), None)
    found = alarm["alarm"] if alarm else {}
    names = (found["effect"], *found["confusable_with"]) if found.get("effect") else ()
    joints = effect.joints if effect else ()
    when = alarm["time"] if alarm else None
    return Outcome(
        kind, name(effect) if effect else None, joints, onset, begins, when, names, tuple(found.get("joints", ()))
    )


def pieces(recording: Recording) -> Iterator[Recording]:
    """Yield the recording as it would come."""
    for first in range(0, len(recording.time), PIECE):
        yield slicing.along_time(recording, slice(first, first + PIECE))


def report(outcomes: Sequence[Outcome]) -> None:
    """Print how often the alarm was false, in time, and right."""
    quiet = [each for each in outcomes if each.effect is None]
    click.echo(f"nothing: {sum(each.alarm is not None for each in quiet)} alarms in {len(quiet)} runs")
    for kind in ("step", "growing"):
        runs = [each for each in outcomes if each.kind == kind and each.begins is not None and each.onset is not None]
        early = sum(each.alarm is not None and each.alarm < (each.begins or 0.0) for each in runs)
        raised = [each for each in runs if each.alarm is not None and each.alarm >= (each.begins or 0.0)]
        in_time = sum((each.alarm or 0.0) <= (each.onset or 0.0) + PATIENCE for each in raised)
        joints = sum(each.named_joints == each.joints for each in raised)
        named = sum(each.effect in each.named for each in raised)
        click.echo(
            f"{kind}: {in_time} of {len(runs)} in time, {early} before; of {len(raised)} alarms joints right in "
            f"{joints}, name in {named}"
        )


@click.command()
@click.option("--folder", type=click.Path(path_type=Path), required=True, help="Of the results.")
@click.option("--runs", type=click.IntRange(1), help="Only the first ones.  [default: all]")
@click.option("--seed", type=click.IntRange(0), help="[default: of the commit]")
def main(folder: Path, runs: int | None, seed: int | None) -> None:
    """Run what is not in the folder yet, and print the figures."""
    seed = int(sources.commit()[:8], 16) if seed is None else seed
    selected = cases()[:runs]
    lines = work.Answers(folder).completed(str(seed), selected, partial(line_of, seed=seed), 1, str)
    report([Outcome(**lines[each.name]["outcome"]) for each in selected])


if __name__ == "__main__":
    main()
