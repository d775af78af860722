"""`python -m benchmarks.arms [--only WORD] [--nothing N]`: effects hidden in simulated arms, and what is named.

MuJoCo's inverse dynamics give the torque of drawn arms of six joints along drawn motions, and the laws of the foreign
plant that of an effect on one or two joints. Its size is 3 % of the torque there, as far as base parameters cannot
take its place. Springs and gaps are moved by forward dynamics, in a motion with accelerations that show them, as are
every second of the arms that hide nothing.
"""

from dataclasses import dataclass
from functools import cached_property, partial
from time import perf_counter

import click
import numpy as np
from scipy.signal import butter, sosfiltfilt

import ident
from benchmarks import flexible_arms
from benchmarks.drawn_arm import JOINTS, RATE, Arm, Way
from drivers.simulated.effect import HiddenEffect, discover, parameter
from drivers.simulated.secant import solve
from recordings.recording import Floats
from tests.foreign import laws

SIZE = 0.03
_NEAR = 0.1
"""Relative error of a size that is good enough."""
_MOTOR = sorted(laws.MOTOR.keys() & discover().keys() - {"torque_offset"})
"""An offset is in the base model of an arm."""
_BEARING = "coupled_joint_friction"
_OTHERS = ("actuation_delay", "base_tilt", "encoder_eccentricity", "encoder_zero_offset", "payload_change", _BEARING)
_COUPLINGS = {"joint_elasticity": ("softness", flexible_arms.spring), "backlash": ("b", flexible_arms.gap)}
EFFECTS = (*_MOTOR, *_OTHERS, *_COUPLINGS)
_WITH_ZERO = range(1, 5)
"""Joints (from 0) whose encoder's zero no parameter of the links replaces."""
_LARGEST = {"encoder_zero_offset": 0.3, "encoder_eccentricity": 0.1}
"""Strengths beyond which no machine has the effect; arms and joints that would need more are drawn again."""
_LARGEST_GROUP = 4
_BANDWIDTH = 20.0


class Bearing(HiddenEffect):
    """Coulomb friction of a joint's own bearing, where its motor turns with another joint, too."""

    b: float = parameter(0.1, "N m", "Coulomb friction", ge=0, le=1e4)


class Springs(HiddenEffect):
    """Springs between motors and arms, of one natural frequency: joints of an arm differ by orders of magnitude."""

    softness: float = parameter(1e-4, "s^2", "1 over the square of the frequency", ge=0, le=1e-3)  # 5 Hz


_OWN: dict[str, type[HiddenEffect]] = {_BEARING: Bearing, "joint_elasticity": Springs}


class Case:
    """One arm with at most one effect, in a recording to learn from and one held out."""

    def __init__(self, effect: str, number: int) -> None:
        self.effect = effect
        self.rng = np.random.default_rng([(*EFFECTS, "nothing").index(effect), number])
        self.hidden: HiddenEffect | None = None
        self.joints: tuple[int, ...] = ()
        """From 0."""
        self.is_fast = effect in _COUPLINGS or (effect == "nothing" and number % 2 == 1)
        self._draw_arm()
        while effect != "nothing" and not self._hide(_OWN.get(effect) or discover()[effect]):
            self._draw_arm()

    def _draw_arm(self) -> None:
        """Draw an arm and its motions."""
        self.arm = Arm(self.rng, self.effect == _BEARING)
        drawn, seconds = (Way.fast, (12.0, 8.0)) if self.is_fast else (Way.drawn, (40.0, 20.0))
        self.ways = [drawn(self.rng, each) for each in seconds]
        self.rigid = [self.arm.rigid(way) for way in self.ways]
        self.__dict__.pop("bare", None)

    def _hide(self, kind: type[HiddenEffect]) -> bool:
        """Draw the effect, its joints and its strength; whether one gives the effect its size."""
        shape = kind.draw_shape(self.rng) | ({"N": 1.0} if self.effect == "encoder_eccentricity" else {})
        possible = {"encoder_zero_offset": _WITH_ZERO, _BEARING: (5,)}.get(self.effect, range(JOINTS))
        joints = self.rng.permutation(list(possible))[: self.rng.integers(1, 3)]
        self.joints = tuple(range(JOINTS) if kind.whole_robot else sorted(joints.tolist()))
        self.hidden = kind.model_validate(shape)
        largest = kind.largest() if self.effect in _COUPLINGS else _LARGEST.get(self.effect, 1e4)
        solved = solve(self.size, SIZE, start=getattr(kind(), kind.strength()), largest=largest)
        if solved is None or abs(solved[1] / SIZE - 1) > _NEAR:
            return False
        self.hidden = self.hidden.scaled(solved[0])
        return True

    def recordings(self) -> list[ident.Recording]:
        """The recordings of the case, with noise and encoder steps."""
        recordings = []
        for way, (position, torque) in zip(self.ways, self.reports(self.hidden), strict=True):
            noise = self.rng.normal(0, 0.01, torque.shape) * torque.std(axis=0)
            steps = np.round(position / 2e-5) * 2e-5
            recordings.append(ident.Recording.from_arrays(way.time, steps, effort=torque + noise, rig=self.arm.rig))
        return recordings

    def reports(self, hidden: HiddenEffect | None) -> list[tuple[Floats, Floats]]:
        """Position and torque (n, 6) of both recordings."""
        return [self._report(way, rigid, hidden) for way, rigid in zip(self.ways, self.rigid, strict=True)]

    def _report(self, way: Way, rigid: Floats, hidden: HiddenEffect | None) -> tuple[Floats, Floats]:
        arm, p = self.arm, hidden.model_dump(exclude={"joints"}) if hidden else {}
        mask = np.isin(np.arange(JOINTS), self.joints)
        q, v = way.position, way.velocity
        state = laws.State(way.time[:, None], q, v, way.acceleration, rigid, arm.coulomb, arm.viscous)
        if self.effect in _COUPLINGS and hidden:
            name, make = _COUPLINGS[self.effect]
            rigid = arm.behind(way, self.joints, partial(make, p[name]))
        speed = v @ arm.motors.T
        torque = rigid + (arm.viscous * speed + arm.coulomb * np.sign(speed)) @ arm.motors
        if self.effect == _BEARING and hidden:
            torque = torque + mask * p["b"] * state.direction
        if self.effect in _MOTOR and hidden:
            torque = torque + mask * laws.MOTOR[self.effect](state, p)
        if self.effect == "base_tilt" and hidden:
            tilt, at = np.sin(p["angle"]), p["direction"]
            tilted = 9.81 * np.array([tilt * np.cos(at), tilt * np.sin(at), -np.cos(p["angle"])])
            torque = torque + arm.rigid(way, tilted) - rigid
        if self.effect == "payload_change" and hidden:
            torque = torque + p["dm"] * arm.per_mass(way) * (way.time > p["t_c"])[:, None]
        if self.effect == "actuation_delay" and hidden:
            late = [np.interp(way.time + p["delay"], way.time, each) for each in torque.T]
            torque = np.where(mask, np.stack(late, axis=1), torque)
        if self.effect == "encoder_eccentricity" and hidden:
            q = q + mask * p["a"] * np.sin(p["N"] * q + p["phase"])
        if self.effect == "encoder_zero_offset" and hidden:
            q = q + mask * p["c"]
        return q, torque

    @cached_property
    def bare(self) -> list[Floats]:
        """(n, 6) of both recordings, what the base model leaves where nothing is hidden."""
        return [
            self._rest(way, way.position, torque)
            for way, (_, torque) in zip(self.ways, self.reports(None), strict=True)
        ]

    def size(self, strength: float) -> float:
        """What base parameters cannot take of the effect, as a share of the torque of its joints."""
        assert self.hidden is not None
        way = self.ways[0]
        position, torque = self._report(way, self.rigid[0], self.hidden.scaled(strength))
        joints = list(self.joints)
        change = (self._rest(way, position, torque) - self.bare[0])[:, joints]
        return float(np.sqrt(np.mean(change**2) / np.mean(self.filtered(torque)[:, joints] ** 2)))

    def _rest(self, way: Way, position: Floats, torque: Floats) -> Floats:
        """(n, 6) what the base model leaves of a `torque`; each joint is weighted by its torque."""
        regressor = self.filtered(self.arm.regressor(way.read_as(position) if position is not way.position else way))
        torque, size = self.filtered(torque), np.sqrt(np.mean(torque**2, axis=0))
        weighted = (regressor / size[:, None]).reshape(-1, regressor.shape[2])
        parameters = np.linalg.lstsq(weighted, (torque / size).ravel(), rcond=1e-8)[0]
        return torque - regressor @ parameters

    @staticmethod
    def filtered(signal: Floats) -> Floats:
        """Every fifth row of a `signal` (n, ...) below the bandwidth of an analysis."""
        return sosfiltfilt(butter(2, _BANDWIDTH, fs=RATE, output="sos"), signal, axis=0)[::5]


@dataclass(frozen=True)
class Named:
    """What a diagnosis says of a case."""

    case: Case
    verdict: str
    findings: tuple[tuple[str, tuple[int, ...], tuple[str, ...]], ...]
    """Effect, joints (from 1), and the effects that it may be instead."""
    seconds: float

    @classmethod
    def of(cls, case: Case) -> "Named":
        """Diagnose the recordings of a case."""
        (train, validate), start = case.recordings(), perf_counter()
        document = ident.diagnose(train, validate=validate).as_json()
        findings = ((f["effect"], tuple(f["joints"]), tuple(f["confusable_with"])) for f in document["findings"])
        return cls(case, document["verdict"], tuple(findings), perf_counter() - start)

    @property
    def is_named(self) -> bool:
        """Whether the effect is in the group of the first finding; with nothing hidden, that there is none."""
        if not self.findings or self.case.effect == "nothing":
            return not self.findings and self.case.effect == "nothing"
        effect, _, others = self.findings[0]
        return self.case.effect in (effect, *others) and len(others) < _LARGEST_GROUP

    @property
    def has_joints(self) -> bool:
        """Whether it is named on its joints; of another of its group any will do."""
        (effect, joints, _), *_ = self.findings or (("", (), ()),)
        return self.is_named and (effect != self.case.effect or joints == tuple(j + 1 for j in self.case.joints))

    def line(self) -> str:
        """The case in one line."""
        mark = "right" if self.has_joints else "joints" if self.is_named else "wrong"
        joints, findings = [joint + 1 for joint in self.case.joints], " ".join(map(str, self.findings))
        return f"{mark:6} {self.case.effect} {joints}: {self.verdict} {findings} ({self.seconds:.1f} s)"


@click.command()
@click.option("--only", metavar="WORD", default="", help="Only effects whose names contain this.")
@click.option("--each", type=click.IntRange(0), default=2, show_default=True, help="Cases of each effect.")
@click.option("--nothing", type=click.IntRange(0), default=20, show_default=True, help="Cases with nothing hidden.")
def main(only: str, each: int, nothing: int) -> None:
    """Hide effects in simulated arms, diagnose them and count those that are named first, on the right joints."""
    counts = {**dict.fromkeys(EFFECTS, each), "nothing": nothing}
    for kinds in (EFFECTS, ("nothing",)):
        answers = []
        for effect, number in ((kind, number) for kind in kinds if only in kind for number in range(counts[kind])):
            answers.append(Named.of(Case(effect, number)))
            click.echo(answers[-1].line())
        named, right = sum(answer.is_named for answer in answers), sum(answer.has_joints for answer in answers)
        click.echo(f"{named} of {len(answers)} right, {right} on the right joints")


if __name__ == "__main__":
    main()
