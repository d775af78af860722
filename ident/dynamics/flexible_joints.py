"""Arms that are coupled to their motors by springs or through backlash, linear about the motion of the motors.

Arms lag behind their motors by a few milliradians: the twists x. The torque that moves them follows from that of arms
which are with their motors:

    torque(q - x, q' - x', q'' - x'') = torque(q, q', q'') - K x - C x' - M x''

Springs that give way by much need more: K, C and M are those of arms at their static lag, and what the torque of the
arms has beyond these terms is computed along the twists that follow, and added, some times.

The compiled kernels are loaded when they are first needed.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ident.basics.slicing import along_time
from ident.dynamics.motion import Motion
from recordings.recording import Floats, Ints
from recordings.rig import Rig
from trajectories.kinematics import Unreachable

_PHASE_STEP = 0.3
"""Integration step, as phase of the fastest oscillation [rad]."""
_MAX_SUBSTEPS = 6
"""Most integration steps per sample; faster oscillations are taken as quasi-static."""
_RESOLVED = 1.0
"""Largest phase step of a resolved oscillation [rad]."""
_BACKLASH_STEP = 5e-4
"""Integration step with backlash [s]."""
_IMPACT = 1e-3
"""Duration of an impact of teeth [s]."""
_SCREENING_STEP = 1e-3
"""Integration step of the backlash screening [s]."""
_DIFFERENCE = 1e-4
"""Change of position, velocity or acceleration for a finite difference, in SI units."""
_LARGEST_LAG = np.array([0.1, 10.0, 1e3])
"""Largest lag of an arm behind its motor and its derivatives, in SI units: a search may try softer springs."""
_CORRECTIONS = 3
"""How often what is not linear is computed: an undamped spring comes out of phase by what is left of it."""
_SAMPLED = 20
"""Number of instants whose natural frequencies are computed."""


def impossible(rig: Rig, joint: int) -> str | None:
    """Tell that loops hold the joints: their torque takes too long to be differentiated in every fit."""
    return "The arms of closed loops are not simulated behind springs and gaps." if rig.loops else None


@dataclass(frozen=True, eq=False)
class LinearArms:
    """Torque of the arms near a motion of n instants, at m of these."""

    instants: Ints
    """(m,) numbers of the instants."""
    motion: Motion
    """Of the arms there."""
    torque_at: Callable[[Motion], Floats]
    """Computes the torque (m, dof) along any motion."""
    torque: Floats
    """(m, dof) along the motion [N m]."""
    matrices: Floats
    """(3, m, dof, dof) its derivatives by position, velocity and acceleration: K, C and M, the inertia matrix."""
    lag: Floats
    """(m, dof) of the arms behind the motors."""
    beyond: Floats
    """(m, dof) torque that - K x lacks at this lag x."""

    @classmethod
    def along(cls, motion: Motion, torque_at: Callable[[Motion], Floats], step: int) -> "LinearArms":
        """Compute them at every `step`-th known instant."""
        state = np.stack([motion.position, motion.velocity, motion.acceleration], axis=1)
        known = np.flatnonzero(np.isfinite(state).all(axis=(1, 2)))[::step]
        instants, dof = known if len(known) else np.zeros(1, int), state.shape[2]
        shifts = np.concatenate([np.zeros((1, 3 * dof)), _DIFFERENCE * np.eye(3 * dof)]).reshape(-1, 3, dof)
        varied = (state[instants, None] + shifts).reshape(-1, 3, dof)
        position, velocity, acceleration = np.ascontiguousarray(varied.transpose(1, 0, 2))
        torques = torque_at(Motion(position, velocity, acceleration, np.zeros_like(velocity)))
        torques = np.nan_to_num(torques.reshape(len(instants), -1, dof))
        slopes = (torques[:, 1:] - torques[:, :1]) / _DIFFERENCE
        matrices = np.stack(np.split(slopes.transpose(0, 2, 1), 3, axis=2))
        lag = np.zeros((len(instants), dof))
        return cls(instants, along_time(motion, instants), torque_at, torques[:, 0], matrices, lag, lag)

    def lagging(self, compliance: Floats) -> "LinearArms":
        """Return those of arms behind springs of about this `compliance` (dof,), linear about their static lag."""
        lag = np.clip(compliance * self.torque, -_LARGEST_LAG[0], _LARGEST_LAG[0])
        try:
            moved = LinearArms.along(
                replace(self.motion, position=self.motion.position - lag), self.torque_at, step=1
            )
        except Unreachable:  # a search may try springs that let the arms fall
            return self
        beyond = moved.torque - self.torque + np.einsum("mij,mj->mi", moved.matrices[0], lag)
        return replace(moved, instants=self.instants, lag=lag, beyond=beyond)

    def bent(self, twists: Floats, joints: Ints) -> Floats:
        """Torque (n, dof) of arms that lag by `twists` (3, n, f) at `joints` (f,), less the linear one."""
        limits, at = _LARGEST_LAG[:, None, None], self.motion
        further = np.zeros((3, *self.torque.shape))
        further[..., joints] = np.clip(np.nan_to_num(twists[:, self.instants]), -limits, limits)
        further[0] -= self.lag
        q, v, a = np.stack([at.position, at.velocity, at.acceleration]) - further
        try:
            torque = self.torque_at(Motion(q, v, a, at.direction))
        except Unreachable:
            torque = np.full_like(self.torque, np.nan)
        linear = self.torque - np.einsum("dmij,dmj->mi", self.matrices, further)
        return self.at_all(twists.shape[1], np.nan_to_num(torque - linear))

    def at_all(self, n: int, values: Floats) -> Floats:
        """Interpolate `values` (m, ...) to all `n` instants: (n, ...)."""
        series = [np.interp(np.arange(n), self.instants, each) for each in values.reshape(len(values), -1).T]
        return np.moveaxis(np.reshape(series, (*values.shape[1:], n)), -1, 0)

    @property
    def smallest_inertia(self) -> Floats:
        """(dof,) smallest inertia of each joint along the motion, the others at rest [kg m^2]; 0 if negative."""
        return np.diagonal(self.matrices[2], axis1=1, axis2=2).min(axis=0).clip(0.0)


@dataclass(frozen=True, eq=False)
class FlexibleJoints:
    """Arms of a robot along a motion of their motors, of n instants."""

    torque: Floats
    """(n, dof) that moves the arms if they follow the motors [N m]; NaN where unknown."""
    motors: Floats
    """(dof,) inertias of the motors, which are not moved by that torque [kg m^2]."""
    near: LinearArms
    """The torque of arms and motors that do not quite follow."""
    rate: float
    """Sampling rate of the motion [Hz]."""

    def change_by_springs(self, compliance: Floats, damping_ratio: float) -> Floats:
        """Change (n, dof) of the torque by springs that connect motors and arms.

        compliance: (dof,), 0 for a stiff joint; damping_ratio: damping over critical damping.
        """
        from ident.dynamics.elastic_kernel import spring_twists

        joints = np.flatnonzero(compliance > 0)
        columns = self._columns(joints)
        K, C, M = (np.ascontiguousarray(each[:, joints]) for each in columns)
        diagonal, c = np.arange(len(joints)), compliance[joints]
        K[:, diagonal, diagonal] += 1 / c
        C[:, diagonal, diagonal] += 2 * damping_ratio * np.sqrt(M[:, diagonal, diagonal].clip(0.0) / c)
        phase = self.natural_frequencies(compliance).max(initial=0.0) / self.rate
        substeps = int(np.clip(np.ceil(phase / _PHASE_STEP), 1, _MAX_SUBSTEPS))
        beta = 1 / 12 if phase < _RESOLVED * substeps else 1 / 4
        torque, step = self._torque(joints), (1 / self.rate, substeps, beta)
        bent = np.zeros_like(self.torque)
        for _ in range(_CORRECTIONS):
            bent = self.near.bent(spring_twists(torque + bent[:, joints], K, C, M, *step), joints)
        return self._change(columns, spring_twists(torque + bent[:, joints], K, C, M, *step)) + bent

    def change_by_backlash(self, half_gap: Floats, impact_delay: float = 0.0) -> Floats:
        """Change (n, dof) of the torque by arms that move by +-`half_gap` (dof,) against their motors.

        impact_delay: time from the contact to the middle of the impact [s].
        """
        from ident.dynamics.backlash_kernel import backlash_twists

        joints = np.flatnonzero(half_gap > 0)
        columns = self._columns(joints)
        arms = (self._torque(joints), *(np.ascontiguousarray(each[:, joints]) for each in columns))
        substeps = int(np.ceil(1 / (self.rate * _BACKLASH_STEP)))
        twists = backlash_twists(*arms, half_gap[joints], _IMPACT, impact_delay, 1 / self.rate, substeps)
        return self._change(columns, twists)

    def cost_reductions(
        self, motor_torque: Floats, joint_inertias: Floats, residual: Floats, motor_shares: Floats, half_gaps: Floats
    ) -> Floats:
        """Estimate the reductions (s, h, dof) of the sum of squares of a `residual` (n, dof) [N m] by backlash.

        Each joint is treated alone. These arms must have the whole `joint_inertias` (dof,) [kg m^2], of which the
        `motor_shares` (s,) are taken away, with their torque `motor_torque` (n, dof); half_gaps: (h,) [rad or m].
        """
        from ident.dynamics.backlash_screening import cost_reductions

        gradient, _, inertia = np.diagonal(self._columns(np.arange(len(joint_inertias))), axis1=2, axis2=3)
        substeps = int(np.ceil(1 / (self.rate * _SCREENING_STEP)))
        return cost_reductions(
            self.torque,
            -gradient,
            np.ascontiguousarray(inertia),
            motor_torque,
            joint_inertias,
            residual,
            motor_shares,
            half_gaps,
            1 / self.rate,
            substeps,
        )

    def _torque(self, joints: Ints) -> Floats:
        """Torque (n, f) of these `joints` (f,), but for what depends on twists; NaN where that of any joint is."""
        torque = self.torque + self._beyond
        return np.where(np.isfinite(torque).all(axis=1, keepdims=True), torque, np.nan)[:, joints]

    @cached_property
    def _beyond(self) -> Floats:
        """(n, dof)."""
        return self.near.at_all(len(self.torque), self.near.beyond)

    def _change(self, columns: Floats, twists: Floats) -> Floats:
        """- K x - C x' - M x'' (n, dof) of `columns` (3, n, dof, f) and `twists` (3, n, f), and what is beyond."""
        return self._beyond - np.einsum("dnjf,dnf->nj", columns, twists)

    def _columns(self, joints: Ints) -> Floats:
        """K, C and M (3, n, dof, f) of these `joints` (f,)."""
        matrices = self.near.matrices.copy()
        matrices[2] -= np.diag(self.motors)
        return np.moveaxis(self.near.at_all(len(self.torque), np.moveaxis(matrices[..., joints], 0, 1)), 1, 0)

    def natural_frequencies(self, compliance: Floats) -> Floats:
        """Natural frequencies (s,) [rad/s] of the joints whose `compliance` (dof,) is positive, at some instants."""
        soft = np.flatnonzero(compliance > 0)
        step = max(1, len(self.near.instants) // _SAMPLED)
        inertia = (self.near.matrices[2, ::step] - np.diag(self.motors))[:, soft[:, None], soft]
        root = np.sqrt(compliance[soft])
        return 1 / np.sqrt(np.linalg.eigvalsh(root[:, None] * inertia * root).clip(1e-12)).ravel()
