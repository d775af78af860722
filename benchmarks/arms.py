"""`python -m benchmarks.arms [--only WORD] [--nothing N]`: effects hidden in simulated arms, and what is named.

MuJoCo's inverse dynamics give the torque of drawn arms of six joints along drawn motions, and the laws of the foreign
plant that of an effect on one or two joints. Its size is 3 % of the torque there, as far as base parameters cannot
take its place. Springs and gaps are moved by forward dynamics, in a motion with accelerations that show them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from time import perf_counter
from typing import Any

import click
import mujoco
import numpy as np
import pinocchio
from scipy.interpolate import make_interp_spline
from scipy.signal import butter, sosfiltfilt

import ident
from benchmarks import flexible_arms
from drivers.simulated.effect import HiddenEffect, discover
from drivers.simulated.secant import solve
from recordings.recording import Floats
from recordings.rig import Rig
from tests.foreign import laws

JOINTS, RATE, SIZE = 6, 250.0, 0.03
_MOTOR = sorted(laws.MOTOR.keys() & discover().keys() - {"torque_offset"})
"""An offset is in the base model of an arm."""
_OTHERS = ("actuation_delay", "base_tilt", "encoder_eccentricity", "encoder_zero_offset", "payload_change")
_COUPLINGS = {"joint_elasticity": ("compliance", flexible_arms.spring), "backlash": ("b", flexible_arms.gap)}
EFFECTS = (*_MOTOR, *_OTHERS, *_COUPLINGS)
_WITH_ZERO = range(1, 5)
"""Joints (from 0) whose encoder's zero no parameter of the links replaces."""
_LARGEST_GROUP = 4
_SIZE_ERROR = 0.05
"""Relative error of the size that is tolerated."""
_BANDWIDTH = 20.0
_AXES = {"roll": "1 0 0", "pitch": "0 1 0", "yaw": "0 0 1"}
_WRISTS = (("pitch", "yaw", "pitch"), ("roll", "pitch", "roll"))


@dataclass(frozen=True, eq=False)
class Way:
    """A motion (n, 6)."""

    time: Floats
    position: Floats
    velocity: Floats
    acceleration: Floats

    @classmethod
    def drawn(cls, rng: np.random.Generator, seconds: float) -> "Way":
        """Draw sums of sines that travel about two radians."""
        time, order = np.arange(0, seconds, 1 / RATE), np.array([1, 2, 3, 5, 8])[:, None]
        size = rng.normal(size=(5, JOINTS)) / order
        size *= rng.uniform(0.7, 1.2, JOINTS) / np.abs(size).sum(axis=0)
        omega, phase = 0.6 * order * rng.uniform(0.93, 1.07, (5, JOINTS)), rng.uniform(0, 2 * np.pi, (5, JOINTS))
        angle = omega * time[:, None, None] + phase
        parts = size * np.sin(angle), size * omega * np.cos(angle), -size * omega**2 * np.sin(angle)
        return cls(time, *(part.sum(axis=1) for part in parts))

    @classmethod
    def fast(cls, rng: np.random.Generator, seconds: float) -> "Way":
        """Draw sums of sines up to 2.5 Hz that travel about a radian, from rest: what shows springs and gaps."""
        time, order = np.arange(0, seconds, 1 / RATE), np.array([1, 2, 3, 5, 7, 9])[:, None]
        size = rng.normal(size=(6, JOINTS)) / order
        size *= rng.uniform(0.4, 0.6, JOINTS) / np.abs(size).sum(axis=0)
        omega, phase = 1.7 * order * rng.uniform(0.93, 1.07, (6, JOINTS)), rng.uniform(0, 2 * np.pi, (6, JOINTS))
        begun = np.clip(time / 1.5, 0, 1)[:, None]
        swell = begun**4 * (35 - 84 * begun + 70 * begun**2 - 20 * begun**3)
        path = make_interp_spline(time, swell * (size * np.sin(omega * time[:, None, None] + phase)).sum(axis=1), 5)
        return cls(time, *(path(time, nu=order) for order in range(3)))

    def read_as(self, position: Floats) -> "Way":
        """The same motion as other angles tell it."""
        velocity = np.gradient(position, 1 / RATE, axis=0)
        return Way(self.time, position, velocity, np.gradient(velocity, 1 / RATE, axis=0))


class Arm:
    """A drawn arm of six revolute joints, with friction and motors to suit."""

    def __init__(self, rng: np.random.Generator) -> None:
        scale, wrist = float(rng.choice([0.6, 1.0, 1.6])), _WRISTS[rng.integers(2)]
        lengths = scale * np.array([0.0, 0.15, 0.45, 0.4, 0.1, 0.1])
        masses = scale**2 * np.array([8.0, 12.0, 6.0, 3.0, 2.0, 0.6]) * rng.uniform(0.7, 1.3, JOINTS)
        centres = scale * rng.uniform([0.05, -0.03, -0.03], [0.15, 0.03, 0.03], (JOINTS, 3))
        axes = [_AXES[name] for name in ("yaw", "pitch", "pitch", *wrist)]
        links = [
            (f"{length:.6f} 0 0", axis, " ".join(f"{x:.6f}" for x in centre), mass, mass * (0.1 * scale) ** 2)
            for length, axis, centre, mass in zip(lengths, axes, centres, masses, strict=True)
        ]
        self.urdf, self._mjcf = _urdf(links), _mjcf(links)
        self.rig = Rig(name="arm", mechanism="urdf", urdf=self.urdf, joints=tuple(f"j{i + 1}" for i in range(JOINTS)))
        self.motor = rng.uniform(0.3, 1.5, JOINTS) * masses * (0.2 * scale) ** 2
        size = np.sqrt(np.mean(self.rigid(Way.drawn(rng, 20.0)) ** 2, axis=0))
        self.coulomb, self.viscous = (rng.uniform(0.06, 0.2, JOINTS) * size for _ in range(2))

    def rigid(self, way: Way, gravity: Sequence[float] | Floats = (0.0, 0.0, -9.81)) -> Floats:
        """(n, 6) torque of links and motors along a motion."""
        model = mujoco.MjModel.from_xml_string(self._mjcf)
        model.opt.gravity[:], data, torque = gravity, mujoco.MjData(model), np.empty_like(way.position)
        for row, at in zip(torque, zip(way.position, way.velocity, way.acceleration, strict=True), strict=True):
            data.qpos[:], data.qvel[:], data.qacc[:] = at
            mujoco.mj_inverse(model, data)
            row[:] = data.qfrc_inverse
        return torque + self.motor * way.acceleration

    def coupled(self, way: Way, joints: Sequence[int], make: Callable[[Floats], flexible_arms.Coupling]) -> Floats:
        """(n, 6) torque of links behind springs or gaps on some `joints`, and of motors that move along `way`."""
        model = mujoco.MjModel.from_xml_string(self._mjcf)
        motors = way.position, way.velocity, way.acceleration
        return flexible_arms.arm_torque(model, way.time, motors, joints, make) + self.motor * way.acceleration

    @cached_property
    def _robot(self) -> Any:
        return pinocchio.buildModelFromXML(self.urdf)

    def per_mass(self, way: Way) -> Floats:
        """(n, 6) torque of 1 kg at the origin of the last link."""
        return self._links(way)[:, :, 10 * (JOINTS - 1)]

    def regressor(self, way: Way) -> Floats:
        """(n, 6, K) of the base model: links, motors, viscous and Coulomb friction, offsets."""
        joints = way.acceleration, way.velocity, np.sign(way.velocity), np.ones_like(way.velocity)
        return np.concatenate([self._links(way), *(signal[:, :, None] * np.eye(JOINTS) for signal in joints)], axis=2)

    def _links(self, way: Way) -> Floats:
        data, at = self._robot.createData(), zip(way.position, way.velocity, way.acceleration, strict=True)
        return np.array([pinocchio.computeJointTorqueRegressor(self._robot, data, *each).copy() for each in at])


def _urdf(links: Sequence[tuple[str, str, str, float, float]]) -> str:
    """The arm as the tool is told of it."""
    bodies = "".join(
        f'<link name="l{i}"><inertial><origin xyz="{centre}"/><mass value="{mass:.9f}"/><inertia ixx="{inertia:.9f}" '
        f'iyy="{inertia:.9f}" izz="{inertia:.9f}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        f'<joint name="j{i}" type="revolute"><parent link="l{i - 1}"/><child link="l{i}"/><origin xyz="{origin}"/>'
        f'<axis xyz="{axis}"/><limit lower="-3" upper="3" effort="1000" velocity="10"/></joint>'
        for i, (origin, axis, centre, mass, inertia) in enumerate(links, 1)
    )
    return f'<robot name="arm"><link name="l0"/>{bodies}</robot>'


def _mjcf(links: Sequence[tuple[str, str, str, float, float]]) -> str:
    """The same arm for MuJoCo."""
    opened = "".join(
        f'<body pos="{origin}"><joint axis="{axis}"/><inertial pos="{centre}" mass="{mass:.9f}" '
        f'diaginertia="{inertia:.9f} {inertia:.9f} {inertia:.9f}"/>'
        for origin, axis, centre, mass, inertia in links
    )
    return f"<mujoco><worldbody>{opened}{'</body>' * len(links)}</worldbody></mujoco>"


class Case:
    """One arm with at most one effect, in a recording to learn from and one held out."""

    def __init__(self, effect: str, number: int) -> None:
        self.effect = effect
        self.rng = np.random.default_rng([(*EFFECTS, "nothing").index(effect), number])
        self.arm = Arm(self.rng)
        drawn, seconds = (Way.fast, (12.0, 8.0)) if effect in _COUPLINGS else (Way.drawn, (40.0, 20.0))
        self.ways = [drawn(self.rng, each) for each in seconds]
        self.rigid = [self.arm.rigid(way) for way in self.ways]
        self.hidden: HiddenEffect | None = None
        self.joints: tuple[int, ...] = ()
        """From 0."""
        if effect != "nothing":
            self._hide(discover()[effect])

    def _hide(self, kind: type[HiddenEffect]) -> None:
        """Draw the effect, its joints and its strength; other joints where hardware has no effect of that size."""
        shape = kind.draw_shape(self.rng) | ({"N": 1.0} if self.effect == "encoder_eccentricity" else {})
        possible = _WITH_ZERO if self.effect == "encoder_zero_offset" else range(JOINTS)
        largest = kind.largest() if self.effect in _COUPLINGS else 1e4
        self.hidden, reached = kind.model_validate(shape), 0.0
        while abs(reached / SIZE - 1) > _SIZE_ERROR:
            joints = self.rng.permutation(list(possible))[: self.rng.integers(1, 3)]
            self.joints = tuple(range(JOINTS) if kind.whole_robot else sorted(joints.tolist()))
            solved = solve(self.size, SIZE, start=getattr(kind(), kind.strength()), largest=largest)
            strength, reached = solved or (0.0, 0.0)
        self.hidden = self.hidden.scaled(strength)

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
            rigid = arm.coupled(way, self.joints, partial(make, p[name]))
        torque = rigid + arm.viscous * v + arm.coulomb * state.direction
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
