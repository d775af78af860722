"""The arms of a mechanism without their motors, followed along a motion that they do not share with them.

The compiled loops are loaded when they are first needed.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ident.dynamics.motion import Motion
from ident.dynamics.rods import GRAVITY
from recordings.recording import Floats
from recordings.rig import Rig

_FINE = 0.3
"""Step of the integration, as an angle of the swing [rad]."""
_MOST_PARTS = 6
"""Steps to a sample; what swings too fast for that follows its load as if at rest."""
_RESOLVED = 1.0
"""Step, as such an angle, up to which a swing is followed."""
_FLIGHT = 5e-4
"""Step of the integration of free flight [s]."""
_GLANCE = 1e-3
"""The same, at a first look [s]."""
_ASIDE = 1e-4
"""Of an arm, for a difference [rad or m]."""


@dataclass(frozen=True, eq=False)
class FlexibleJoints:
    """Arms of a delta robot, or of independent axes, as numbers for the compiled loops."""

    delta: bool
    constants: Floats
    rate: float
    """Instants per second of the motions [Hz]."""

    def rigid_torque(self, motion: Motion) -> Floats:
        """Torque (n, dof) [N m] that the arms take if they follow the motors."""
        from ident.dynamics.flexible_joint_kernels import along

        taken: Floats = along(self.delta, self.constants, *_moved(motion))[0]
        return taken

    def elastic_torque(self, motion: Motion, compliance: Floats, damping_ratio: float) -> Floats:
        """Torque (n, dof) [N m] that the arms take if motor and arm are joined by springs.

        compliance: (dof,), 0 for a stiff joint; ratio: of the damping to the critical one.
        """
        from ident.dynamics.flexible_joint_kernels import on_springs

        turned = self.natural_frequencies(motion, compliance).max(initial=0.0) / self.rate
        parts = int(np.clip(np.ceil(turned / _FINE), 1, _MOST_PARTS))
        beta = 1 / 12 if turned < _RESOLVED * parts else 1 / 4
        taken: Floats = on_springs(
            self.delta, self.constants, *_moved(motion), compliance, damping_ratio, 1 / self.rate, parts, beta
        )
        return taken

    def backlash_torque(self, motion: Motion, half_gap: Floats) -> Floats:
        """Torque (n, dof) [N m] that the arms take if they can move by +-`half` (dof,) against the motors."""
        from ident.dynamics.flexible_joint_kernels import with_play

        parts = int(np.ceil(1 / (self.rate * _FLIGHT)))
        taken: Floats = with_play(self.delta, self.constants, *_moved(motion), half_gap, 1 / self.rate, parts)
        return taken

    def cost_reductions(
        self, motion: Motion, joint_inertias: Floats, residual: Floats, motor_shares: Floats, half_gaps: Floats
    ) -> Floats:
        """(s, h, dof) fall of the sum of squares of a `residual` (n, dof) [N m] by play, at a first look.

        Each joint is taken by itself. own: (dof,) inertia [kg m^2] of which motors may have the `shares` (s,) - these
        arms are to have all of it; halves: (h,) of the play.
        """
        from ident.dynamics.backlash_screening import falls
        from ident.dynamics.flexible_joint_kernels import along

        position, velocity, acceleration = _moved(motion)
        load, inertia = along(self.delta, self.constants, position, velocity, acceleration)
        tilt = np.empty_like(load)
        for joint, aside in enumerate(_ASIDE * np.eye(load.shape[1])):
            ahead = along(self.delta, self.constants, position - aside, velocity, acceleration)[0]
            tilt[:, joint] = (ahead[:, joint] - load[:, joint]) / _ASIDE
        push = joint_inertias * motion.acceleration
        parts = int(np.ceil(1 / (self.rate * _GLANCE)))
        fallen: Floats = falls(
            load, tilt, inertia, push, joint_inertias, residual, motor_shares, half_gaps, 1 / self.rate, parts
        )
        return fallen

    def natural_frequencies(self, motion: Motion, compliance: Floats) -> Floats:
        """(s,) [rad/s] at which the arms swing on those joints that have a `compliance` (dof,), about."""
        from ident.dynamics.flexible_joint_kernels import along

        known, soft = np.isfinite(motion.acceleration).all(axis=1), compliance > 0
        if not known.any():
            return np.empty(0)
        first = slice(np.argmax(known), np.argmax(known) + 1)
        own = along(self.delta, self.constants, *(signal[first] for signal in _moved(motion)))[1][0, soft]
        rates: Floats = np.sqrt(1 / (compliance[soft] * np.maximum(own, 1e-9)))
        return rates


def flexible_joints(rig: Rig, parameters: Mapping[str, float], share: float, rate: float) -> FlexibleJoints:
    """The arms of `rig` with a mechanism's `parameters` by name, less the motors' `share` of each joint's inertia."""
    joints = range(1, rig.dof + 1)
    own = joint_inertia(parameters, rig.dof) * (1 - share)
    if rig.mechanism == "delta":
        lengths, phi = rig.geometry, np.array(rig.geometry.phi)
        weights = (max(parameters["m_p"], 0.0), parameters["T_g"], max(parameters.get("m_d", 0.0), 0.0))
        fixed = (lengths.L1, lengths.L2, lengths.R - lengths.r, GRAVITY, *weights)
        return FlexibleJoints(True, np.array([*fixed, *np.cos(phi), *np.sin(phi), *own]), rate)
    weight = [[parameters.get(f"{name}{j}", 0.0) for j in joints] for name in ("G_c", "G_s", "G_")]
    return FlexibleJoints(False, np.concatenate([own, *weight]), rate)


def joint_inertia(parameters: Mapping[str, float], dof: int) -> Floats:
    """(dof,) inertia of each joint by itself, arm and motor [kg m^2 or kg]; 0 where a fit made it negative."""
    found = (parameters.get(f"I_{j}", parameters.get(f"m_{j}", 0.0)) for j in range(1, dof + 1))
    return np.array([max(inertia, 0.0) for inertia in found])


def _moved(motion: Motion) -> tuple[Floats, Floats, Floats]:
    signals = (motion.position, motion.velocity, motion.acceleration)
    position, velocity, acceleration = (np.ascontiguousarray(signal) for signal in signals)
    return position, velocity, acceleration
