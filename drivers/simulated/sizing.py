"""Size of a hidden effect: its residual after a fit of the base model, relative to the torque.

The machine runs along fig5a, without bus, noise or quantisation, with and without the effect. The base model
is fitted to its reported values both times: positions of the encoders, torques of the voltages by the rig's map. The
size is the RMS of the difference of the two residuals over the RMS of the torque, on the joints of the effect.
Effects of drives and sensors are thus measured, like all others, by the torque error that they cause in the model.
"""

import math
from collections.abc import Sequence

import numpy as np

from drivers.simulated.base_model_residual import BaseModelResidual, JointMotion, base_model_residual
from drivers.simulated.config import EffectSpec, SimConfig
from drivers.simulated.effect import HiddenEffect, build
from drivers.simulated.machine import SimulatedMachine, plant_step
from drivers.simulated.secant import TOLERANCE, nearest, unabsorbed
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories.kinematics import Unreachable
from trajectories.library import load

_STEPS_PER_SAMPLE = 4
"""Plant steps per sample."""
_FIT_DECIMATION = 5
"""Samples per row of the fit."""
_MARGIN = 0.15
"""Motion after the repetitions, for the low-pass filter [s]."""
_UNSTABLE_CHANGE = 0.3
"""Change of the acceleration by an effect, relative to it, above which the loop counts as unstable."""


class EffectSizer:
    """Measures the size of effects on one robot, with the fewest repetitions of fig5a that an effect allows."""

    def __init__(self, rig: Rig, config: SimConfig) -> None:
        """`config`: the machine; its effects are omitted."""
        self._rig = rig
        self._config = config.model_copy(update={"effects": (), "events": ()})
        self._runs: dict[int, _TrajectoryRun] = {}

    def size(self, effect: HiddenEffect) -> float:
        """The effect's size; infinite if the robot cannot follow the trajectory with it.

        Effects that happen at an instant happen in the middle of the motion.

        Raises:
            BadInput: the robot cannot follow the trajectory even without the effect.
        """
        if effect.cycles not in self._runs:
            self._runs[effect.cycles] = _TrajectoryRun(self._rig, self._config, effect.cycles)
        return self._runs[effect.cycles].size(effect)

    def nearest(self, effect: HiddenEffect, target_size: float) -> tuple[HiddenEffect, float]:
        """The effect with the strength, of the same sign, whose size is nearest to `target_size`; and that size.

        Raises:
            BadInput: as `size`, or the robot cannot follow the trajectory with any strength tried.
        """
        found = nearest(self.size, effect, target_size)
        if found is None:
            raise BadInput(
                f"effect {effect.name()} makes this robot unstable at any strength; change its other parameters"
            )
        return found


class _TrajectoryRun:
    """Some repetitions of fig5a, and the base-model residual of the machine without effects on them."""

    def __init__(self, rig: Rig, config: SimConfig, cycles: int) -> None:
        self._rig, self._config = rig, config
        dt = plant_step(rig.rate)
        self._dt = _STEPS_PER_SAMPLE * dt
        trajectory = load("fig5a", rig, cycles=cycles, rate=1 / dt)
        repeated = np.flatnonzero(trajectory.repeat >= 0) // _STEPS_PER_SAMPLE
        self._window = slice(int(repeated[0]), int(repeated[-1]) + 1)
        self._start: list[float] = trajectory.platform[0].tolist()
        samples = self._window.stop + round(_MARGIN / self._dt)
        self._setpoints = trajectory.joint_position[: samples * _STEPS_PER_SAMPLE].reshape(
            samples, _STEPS_PER_SAMPLE, 3
        )
        bare = self._residual_with(())
        if bare is None:
            raise BadInput("the simulated robot cannot follow fig5a; change its servo or its links in the sim file")
        self._bare = bare

    def size(self, effect: HiddenEffect) -> float:
        middle = (self._window.start + self._window.stop) / 2 * self._dt
        joints = [joint - 1 for joint in effect.joints]
        fits, bare = [self._residual_with((each.at(middle),)) for each in (effect, *effect.contained())], self._bare
        if any(
            fit is None or _rms(fit.acceleration - bare.acceleration) > _UNSTABLE_CHANGE * _rms(bare.acceleration)
            for fit in fits
        ):
            return math.inf
        change, *contained = [fit.residual - bare.residual for fit in fits if fit is not None]
        return _rms(unabsorbed(change, contained)[:, joints]) / _rms(bare.torque[:, joints])

    def _residual_with(self, effects: Sequence[HiddenEffect]) -> BaseModelResidual | None:
        """Residual of the base model; None if the robot does not follow the trajectory."""
        try:
            motion = self._reported_motion(effects)
            error = np.abs(self._setpoints[:, -1] - motion.position)[self._window]
            if not np.max(error) < self._rig.limits.following_error:
                return None
            return base_model_residual(self._rig.geometry, motion, self._dt, self._window, _FIT_DECIMATION)
        except Unreachable:
            return None

    def _reported_motion(self, effects: Sequence[HiddenEffect]) -> JointMotion:
        """Motion reported by the machine with these effects."""
        specs = tuple(effect.spec() for effect in effects)
        machine = SimulatedMachine(
            self._rig, self._config.model_copy(update={"effects": specs}), np.random.default_rng(0)
        )
        machine.reset(self._start)
        machine.enabled, machine.brake = [True] * 3, [False] * 3
        rows = []
        for setpoints in self._setpoints.tolist():
            machine.advance(setpoints)
            rows.append((machine.position(), machine.velocity(), machine.reported_torque()))
        position, velocity, torque = np.moveaxis(np.array(rows), 1, 0)
        acceleration: Floats = np.gradient(velocity, self._dt, axis=0)
        return JointMotion(position=position, velocity=velocity, acceleration=acceleration, torque=torque)


def resolve(rig: Rig, config: SimConfig) -> SimConfig:
    """Convert the sizes of the effects to parameters.

    Raises:
        BadInput: an effect is not valid or cannot have its size on this robot.
    """
    effects = [build(spec) for spec in config.all_effects]
    for spec, effect in zip(config.all_effects, effects, strict=True):
        if spec.size is not None and effect.strength() in spec.parameters:
            raise BadInput(f"effect {spec.name}: a size or '{effect.strength()}' expected, both found; remove one")
    if all(spec.size is None for spec in config.all_effects):
        return config
    sizer = EffectSizer(rig, config)
    return config.with_effects(
        [_resolve(sizer, spec, effect) for spec, effect in zip(config.all_effects, effects, strict=True)]
    )


def _resolve(sizer: EffectSizer, spec: EffectSpec, effect: HiddenEffect) -> EffectSpec:
    if spec.size is None:
        return spec
    effect, size = sizer.nearest(effect, spec.size)
    if abs(size / spec.size - 1) > 2 * TOLERANCE:
        raise BadInput(
            f"effect {spec.name}: a size of {spec.size:g} is not possible on joints {list(spec.joints)}, "
            f"{size:.3g} is the nearest; change the size or the other parameters"
        )
    return effect.spec()


def _rms(values: Floats) -> float:
    return math.sqrt(float(np.mean(values**2)))
