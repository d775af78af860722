"""`python -m benchmarks.set_ups [--each N] [--unknown N]`: what several payloads tell that one set-up does not.

Friction of the load is hidden in simulated lifts and arms, recorded with three known payloads: what does one
set-up name, and what do all three? Then an unknown payload of swinging axes and of arms is fitted beside an empty
robot, and its intervals should hold the truth.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import click
import mujoco
import numpy as np

import ident
from benchmarks.drawn_arm import JOINTS, Arm, Way
from recordings.recording import Floats
from recordings.rig import Axis, Rig
from recordings.urdf import Payload

HIDDEN = "load_dependent_friction"
_NOISE = 0.01
"""Of the torque."""
_GRAVITY = 9.81


class SwingingAxis:
    """A drawn revolute axis whose arm swings about the horizontal, with friction."""

    joints, hidden, travel = 1, 0, 1.0
    place = (0.4, 0.0, 0.1)

    def __init__(self, rng: np.random.Generator) -> None:
        self.inertia, self.weight = rng.uniform(0.3, 1.0), rng.uniform(3.0, 12.0)
        self.mass = self.weight / _GRAVITY / self.place[0]

    def rig(self, payload: Payload | None) -> Rig:
        """The rig file with a payload."""
        return Rig(name="axis", mechanism="axes", axes=(Axis(gravity=True),), payload=payload)

    def rigid(self, way: Way, mass: float) -> Floats:
        """(n, 1) torque with a payload of a `mass` [kg]."""
        (x, _, z), q = self.place, way.position
        own = self.inertia * way.acceleration + self.weight * np.cos(q)
        return own + mass * ((x**2 + z**2) * way.acceleration + _GRAVITY * (x * np.cos(q) - z * np.sin(q)))


class Lift:
    """A drawn vertical slide: its load hardly changes, so that one payload hardly shows friction of the load."""

    joints, hidden, travel = 1, 0, 0.1
    place = (0.0, 0.0, 0.0)

    def __init__(self, rng: np.random.Generator) -> None:
        self.own = rng.uniform(2.0, 10.0)
        self.mass = self.own * rng.uniform(0.3, 1.0)

    def rig(self, payload: Payload | None) -> Rig:
        """The rig file with a payload."""
        return Rig(name="lift", mechanism="axes", axes=(Axis(type="prismatic", gravity=True),), payload=payload)

    def rigid(self, way: Way, mass: float) -> Floats:
        """(n, 1) force with a payload of a `mass` [kg]."""
        return (self.own + mass) * (way.acceleration + _GRAVITY)


class LoadedArm:
    """A drawn arm of six joints, whose third one loses a share of its load."""

    joints, hidden, travel = JOINTS, 2, 1.0
    place = (0.1, 0.02, 0.05)

    def __init__(self, rng: np.random.Generator) -> None:
        self._arm = Arm(rng)
        self.mass = 0.5 * rng.uniform(3.0, 6.0)

    def rig(self, payload: Payload | None) -> Rig:
        """The rig file with a payload."""
        return self._arm.rig.model_copy(update={"payload": payload})

    def rigid(self, way: Way, mass: float) -> Floats:
        """(n, 6) torque with a payload of a `mass` [kg], by MuJoCo."""
        load = '<body pos="{} {} {}"><inertial pos="0 0 0" mass="{}" diaginertia="1e-9 1e-9 1e-9"/></body>'
        ends = "</body>" * JOINTS
        text = self._arm.mjcf.replace(ends, load.format(*self.place, mass) + ends) if mass else self._arm.mjcf
        return self._arm.rigid(way, model=mujoco.MjModel.from_xml_string(text))


Robot = SwingingAxis | Lift | LoadedArm


def motion_of(robot: Robot, rng: np.random.Generator, seconds: float) -> Way:
    """Draw a motion of the joints of `robot`."""
    whole = Way.drawn(rng, seconds)
    signals = (whole.position, whole.velocity, whole.acceleration)
    return Way(whole.time, *(robot.travel * each[:, : robot.joints] for each in signals))


@dataclass(frozen=True)
class Case:
    """A robot that is recorded with several payloads."""

    robot: Robot
    friction: Floats
    """(joints,) Coulomb friction, and viscous friction at 1 rad/s [N m]."""
    lost: float
    """Share of the load that the joint loses."""
    rng: np.random.Generator

    @classmethod
    def drawn(cls, number: int, axis: type[SwingingAxis | Lift] = SwingingAxis) -> "Case":
        """Draw an `axis` or, with an odd `number`, an arm."""
        rng = np.random.default_rng([7, number])
        robot = (LoadedArm if number % 2 else axis)(rng)
        friction = 0.1 * np.abs(robot.rigid(motion_of(robot, rng, 20.0), 0.0)).mean(axis=0)
        return cls(robot, friction, rng.uniform(0.05, 0.15), rng)

    def record(self, mass: float, seconds: float, told: Payload | None) -> ident.Recording:
        """A motion with a payload of this `mass`, which the rig file says to be the `told` one."""
        way = motion_of(self.robot, self.rng, seconds)
        rigid = self.robot.rigid(way, mass)
        lost = self.lost * (np.arange(self.robot.joints) == self.robot.hidden)
        torque = rigid + self.friction * way.velocity + (self.friction + lost * np.abs(rigid)) * np.sign(way.velocity)
        torque += _NOISE * np.abs(rigid).mean(axis=0) * self.rng.normal(size=torque.shape)
        position = np.round(way.position / 2e-5) * 2e-5
        return ident.Recording.from_arrays(way.time, position, effort=torque, rig=self.robot.rig(told))

    def known(self, share: float) -> tuple[ident.Recording, ident.Recording]:
        """Recordings to learn from and to hold out, with a known payload of a `share` of the mass."""
        mass = share * self.robot.mass
        told = Payload(mass=mass, com=self.robot.place) if mass else None
        return self.record(mass, 20.0, told), self.record(mass, 10.0, told)


def names(train: list[ident.Recording], validate: list[ident.Recording]) -> list[str]:
    """The first finding, and what it could be instead."""
    findings = ident.diagnose(train, validate=validate).findings
    return [findings[0].effect, *findings[0].confusable_with] if findings else []


def separated(count: int) -> Iterator[str]:
    """Yield a line for each of `count` cases, and how many are named alone by three set-ups."""
    answers = list[tuple[bool, bool]]()
    for number in range(count):
        pairs = [Case.drawn(number, Lift).known(share) for share in (0.0, 1.0, 2.0)]
        train, held_out = ([pair[k] for pair in pairs] for k in (0, 1))
        alone, together = names(train[:1], held_out[:1]), names(train, held_out)
        answers.append((alone == [HIDDEN], together == [HIDDEN]))
        yield f"{number}: one set-up {' or '.join(alone) or 'nothing'}; three {' or '.join(together) or 'nothing'}"
    left = [by_three for by_one, by_three in answers if not by_one]
    yield f"one set-up does not name it alone in {len(left)} of {count}; of these three set-ups do in {sum(left)}"


def found(count: int) -> Iterator[str]:
    """Yield how often the intervals of an unknown payload hold its mass, of `count` cases, and its place."""
    holds = []
    for number in range(count):
        case = Case.drawn(number)
        mass = case.robot.mass * case.rng.uniform(0.5, 2.0)
        empty, loaded = case.record(0.0, 20.0, None), case.record(mass, 20.0, Payload(mass="unknown", com="unknown"))
        model = ident.fit([empty, loaded], method="wls", effects=[f"{HIDDEN}:{case.robot.hidden + 1}"])
        truth = dict(zip("mxyz", (mass, *case.robot.place), strict=True))
        limits = {name: model.parameters[f"unknown_payload.{name}"].ci95 for name in truth}
        holds += [(name, ci[0] <= truth[name] <= ci[1]) for name, ci in limits.items() if ci]
    for name in "mxyz":
        inside = [held for each, held in holds if each == name]
        yield f"{name} of an unknown payload in its 95 % interval: {sum(inside)} of {len(inside)}"


@click.command()
@click.option("--each", type=click.IntRange(0), default=20, show_default=True, help="Robots with three payloads.")
@click.option("--unknown", type=click.IntRange(0), default=60, show_default=True, help="Unknown payloads.")
def main(each: int, unknown: int) -> None:
    """Hide friction of the load, and payloads, and count what several set-ups tell."""
    for lines in (separated(each), found(unknown)):
        for line in lines:
            click.echo(line)


if __name__ == "__main__":
    main()
