"""How large a hidden effect is: what a fit of the base model leaves of it, as a share of the torque.

The machine runs along a trajectory, without bus, noise or quantisation, with and without the effect, and the base
model is fitted to what it reports both times: positions as its encoders read them, torques as its voltages say by the
rig's map. The difference of the two residuals over the torque, both as RMS over the joints concerned, is the size. So
effects of the drives and the sensors are measured by the torque that they make the model miss, like all others.
"""

import math
from collections.abc import Sequence

import numpy as np

from drivers.simulated.config import EffectSpec, SimConfig
from drivers.simulated.effect import HiddenEffect, build
from drivers.simulated.machine import Machine, plant_step
from drivers.simulated.base_model_residual import JointMotion, BaseModelResidual, base_model_residual
from drivers.simulated.secant import solve
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories.kinematics import Unreachable
from trajectories.library import load

_LOOK_EVERY = 4
"""Steps of the plant between two looks at it."""
_FIT_EVERY = 5
"""Looks between two rows of the fit."""
_MARGIN = 0.15
"""Of the motion beyond the repetitions, for the low-pass [s]."""
_CLOSE_ENOUGH = 0.01
"""Relative error of a size that was asked for."""
_SHAKING = 0.3
"""How far an effect may change the acceleration, as a share of it, before the loop counts as unstable."""


class EffectSizer:
    """Measures effects on one robot and one trajectory, of which it runs as few repetitions as the effect allows."""

    def __init__(self, rig: Rig, config: SimConfig, trajectory: str = "fig5a") -> None:
        """`config`: the machine; effects of its own are left out."""
        self._rig = rig
        self._config = config.model_copy(update={"effects": ()})
        self._trajectory = trajectory
        self._runs: dict[int, _Run] = {}

    def size(self, effect: HiddenEffect) -> float:
        """The effect's size; infinite where it keeps the robot from following the trajectory.

        What happens at some instant is made to happen in the middle of the motion.

        Raises:
            BadInput: no such trajectory, or the robot cannot follow it without the effect either.
        """
        if effect.cycles not in self._runs:
            self._runs[effect.cycles] = _Run(self._rig, self._config, self._trajectory, effect.cycles)
        return self._runs[effect.cycles].size(effect)

    def nearest(self, effect: HiddenEffect, wanted: float) -> tuple[HiddenEffect, float]:
        """The effect with the strength, of the same sign, that brings its size nearest to `wanted`; and that size.

        Raises:
            BadInput: as `size`, or the robot cannot follow with any strength that was tried.
        """
        sign = math.copysign(1.0, effect.model_dump()[effect.strength()])
        found = solve(
            lambda strength: self.size(effect.scaled(sign * strength)),
            wanted,
            start=abs(type(effect)().model_dump()[effect.strength()]),
            largest=effect.largest(),
            tolerance=_CLOSE_ENOUGH,
        )
        if found is None:
            raise BadInput(f"effect {effect.name()} shakes this robot at any strength; change its other parameters")
        strength, size = found
        return effect.scaled(sign * strength), size


class _Run:
    """Some repetitions of a trajectory, and what the base model leaves of the bare machine on them."""

    def __init__(self, rig: Rig, config: SimConfig, name: str, cycles: int) -> None:
        self._rig, self._config = rig, config
        dt = plant_step(rig.rate)
        self._dt = _LOOK_EVERY * dt
        trajectory = load(name, rig, cycles=cycles, rate=1 / dt)
        repeating = np.flatnonzero(trajectory.repeat >= 0) // _LOOK_EVERY
        self._window = slice(int(repeating[0]), int(repeating[-1]) + 1)
        self._start: list[float] = trajectory.platform[0].tolist()
        looks = self._window.stop + round(_MARGIN / self._dt)
        self._setpoints = trajectory.joint_position[: looks * _LOOK_EVERY].reshape(looks, _LOOK_EVERY, 3)
        bare = self._left(())
        if bare is None:
            raise BadInput(f"the simulated robot cannot follow {name}; change its servo or its links in the sim file")
        self._bare = bare

    def size(self, effect: HiddenEffect) -> float:
        middle = (self._window.start + self._window.stop) / 2 * self._dt
        joints = [joint - 1 for joint in effect.joints]
        left, bare = self._left((effect.at(middle),)), self._bare
        if left is None or _rms(left.acceleration - bare.acceleration) > _SHAKING * _rms(bare.acceleration):
            return math.inf
        return _rms((left.residual - bare.residual)[:, joints]) / _rms(bare.torque[:, joints])

    def _left(self, effects: Sequence[HiddenEffect]) -> BaseModelResidual | None:
        """What the base model leaves; None where the robot does not follow."""
        try:
            motion = self._follow(effects)
            error = np.abs(self._setpoints[:, -1] - motion.position)[self._window]
            if not np.max(error) < self._rig.limits.following_error:
                return None
            return base_model_residual(self._rig.geometry, motion, self._dt, self._window, _FIT_EVERY)
        except Unreachable:
            return None

    def _follow(self, effects: Sequence[HiddenEffect]) -> JointMotion:
        """What the machine with these effects reports."""
        specs = tuple(effect.spec() for effect in effects)
        machine = Machine(self._rig, self._config.model_copy(update={"effects": specs}), np.random.default_rng(0))
        machine.reset(self._start)
        machine.enabled, machine.brake = [True] * 3, [False] * 3
        rows = []
        for setpoints in self._setpoints.tolist():
            machine.advance(setpoints)
            rows.append((machine.position(), machine.velocity(), machine.reported_torque()))
        position, velocity, torque = np.moveaxis(np.array(rows), 1, 0)
        acceleration: Floats = np.gradient(velocity, self._dt, axis=0)
        return JointMotion(position=position, velocity=velocity, acceleration=acceleration, torque=torque)


def resolve(rig: Rig, config: SimConfig, sizer: EffectSizer | None = None) -> SimConfig:
    """The same machine, its effects given by parameters in place of sizes; `ruler`: one made for it before.

    Raises:
        BadInput: an effect is not valid or cannot be that large on this robot.
    """
    effects = [build(spec) for spec in config.effects]
    for spec, effect in zip(config.effects, effects, strict=True):
        if spec.size is not None and effect.strength() in spec.parameters:
            raise BadInput(f"effect {spec.name}: a size or '{effect.strength()}' expected, both found; remove one")
    if all(spec.size is None for spec in config.effects):
        return config
    sizer = sizer or EffectSizer(rig, config)
    resolved = tuple(_resolved(sizer, spec, effect) for spec, effect in zip(config.effects, effects, strict=True))
    return config.model_copy(update={"effects": resolved})


def _resolved(ruler: EffectSizer, spec: EffectSpec, effect: HiddenEffect) -> EffectSpec:
    if spec.size is None:
        return spec
    effect, size = ruler.nearest(effect, spec.size)
    if abs(size / spec.size - 1) > 2 * _CLOSE_ENOUGH:
        raise BadInput(
            f"effect {spec.name}: a size of {spec.size:g} cannot be had on joints {list(spec.joints)}, "
            f"{size:.3g} is the nearest; change the size or the other parameters"
        )
    return effect.spec()


def _rms(values: Floats) -> float:
    return math.sqrt(float(np.mean(values**2)))
