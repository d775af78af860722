"""How large a hidden effect is: what a fit of the base model leaves of it, as a share of the torque.

The machine runs along a trajectory, without bus, noise or quantisation, with and without the effect, and the base
model is fitted to both. What remains with the effect, less what remains without, over the torque, all as RMS over the
joints concerned, is the size.
"""

import math
from collections.abc import Sequence

import numpy as np

from drivers.simulated.config import EffectSpec, SimConfig
from drivers.simulated.effect import Effect, build
from drivers.simulated.machine import Machine, step
from drivers.simulated.remainder import Motion, Remainder, remainder
from recordings.errors import BadInput
from recordings.rig import Rig
from trajectories.library import load

_FIT_EVERY = 20
_TRIALS = 7
_CLOSE_ENOUGH = 0.01
"""Relative error of a size that was asked for."""
_LONGEST_STRIDE = math.log(10)
"""Of the search, on the logarithm of the strength."""


class Ruler:
    """Measures effects on one robot and one trajectory, of which it runs a single repetition."""

    def __init__(self, rig: Rig, config: SimConfig, trajectory: str = "fig5a") -> None:
        """`config`: the machine; effects of its own are left out.

        Raises:
            BadInput: no such trajectory, or the robot cannot follow it.
        """
        self._rig = rig
        self._config = config.model_copy(update={"effects": ()})
        self._dt = step(rig.rate)
        self._trajectory = load(trajectory, rig, cycles=1, rate=1 / self._dt)
        repeating = np.flatnonzero(self._trajectory.repeat >= 0)
        self._window = slice(int(repeating[0]), int(repeating[-1]) + 1)
        self._bare = self._remainder(())

    def size(self, effect: Effect) -> float:
        """The effect's size. What happens at some instant is made to happen in the middle of the motion."""
        middle = (self._window.start + self._window.stop) / 2 * self._dt
        joints = [joint - 1 for joint in effect.joints]
        excess = self._remainder((effect.at(middle),)).residual[joints] - self._bare.residual[joints]
        return math.sqrt(max(float(excess.sum()), 0.0) / float(self._bare.torque[joints].sum()))

    def nearest(self, effect: Effect, wanted: float) -> tuple[Effect, float]:
        """The effect with the strength, of the same sign, that brings its size nearest to `wanted`; and that size.

        Secant steps on the logarithms of strength and size, where most effects are straight lines.
        """
        sign = math.copysign(1.0, effect.model_dump()[effect.strength()])

        def scaled(x: float) -> Effect:
            # The exponential of a logarithm may miss the bound by its last bit.
            return effect.scaled(sign * min(math.exp(x), effect.largest()))

        goal, most = math.log(wanted), math.log(effect.largest())
        tried: list[tuple[float, float]] = []
        x = math.log(effect.largest() / 10)
        for _ in range(_TRIALS):
            size = self.size(scaled(x))
            tried.append((x, math.log(max(size, 1e-9))))
            if abs(tried[-1][1] - goal) < _CLOSE_ENOUGH or (x == most and tried[-1][1] < goal):
                break
            stride = (goal - tried[-1][1]) / _slope(tried)
            x = min(x + min(max(stride, -_LONGEST_STRIDE), _LONGEST_STRIDE), most)
        x, reached = min(tried, key=lambda trial: abs(trial[1] - goal))
        return scaled(x), math.exp(reached)

    def _remainder(self, effects: Sequence[Effect]) -> Remainder:
        specs = tuple(effect.spec() for effect in effects)
        machine = Machine(self._rig, self._config.model_copy(update={"effects": specs}), np.random.default_rng(0))
        machine.reset(self._trajectory.platform[0].tolist())
        machine.enabled, machine.brake = [True] * 3, [False] * 3
        rows = []
        for setpoint in self._trajectory.joint_position.tolist():
            machine.advance((setpoint,))
            rows.append((machine.position(), machine.velocity(), machine.acceleration(), machine.commanded_torque()))
        position, velocity, acceleration, torque = np.moveaxis(np.array(rows), 1, 0)
        motion = Motion(position=position, velocity=velocity, acceleration=acceleration, torque=torque)
        return remainder(self._rig.geometry, motion, self._dt, self._window, _FIT_EVERY)


def resolve(rig: Rig, config: SimConfig) -> SimConfig:
    """The same machine, its effects given by parameters in place of sizes.

    Raises:
        BadInput: an effect is not valid or cannot be that large on this robot.
    """
    effects = [build(spec) for spec in config.effects]
    for spec, effect in zip(config.effects, effects, strict=True):
        if spec.size is not None and effect.strength() in spec.parameters:
            raise BadInput(f"effect {spec.name}: a size or '{effect.strength()}' expected, both found; remove one")
    if all(spec.size is None for spec in config.effects):
        return config
    ruler = Ruler(rig, config)
    resolved = tuple(_resolved(ruler, spec, effect) for spec, effect in zip(config.effects, effects, strict=True))
    return config.model_copy(update={"effects": resolved})


def _resolved(ruler: Ruler, spec: EffectSpec, effect: Effect) -> EffectSpec:
    if spec.size is None:
        return spec
    effect, size = ruler.nearest(effect, spec.size)
    if abs(size / spec.size - 1) > 2 * _CLOSE_ENOUGH:
        raise BadInput(
            f"effect {spec.name}: a size of {spec.size:g} cannot be had on joints {list(spec.joints)}, "
            f"{size:.3g} is the nearest; change the size or the other parameters"
        )
    return effect.spec()


def _slope(tried: Sequence[tuple[float, float]]) -> float:
    """Of size over strength, both logarithms, between the last two trials; 1 where they do not tell."""
    if len(tried) < 2:
        return 1.0
    (x0, y0), (x1, y1) = tried[-2:]
    slope = (y1 - y0) / (x1 - x0) if x1 != x0 else 1.0
    return min(max(slope, 0.3), 3.0)
