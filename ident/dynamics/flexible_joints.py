"""Arms that are coupled to their motors by springs or through backlash, linear about the motion of the motors.

Arms lag behind their motors by a few milliradians: the twists x. The torque that moves them follows from that of arms
which are with their motors:

    torque(q - x, q' - x', q'' - x'') = torque(q, q', q'') - K x - C x' - M x''

The compiled kernels are loaded when they are first needed.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ident.dynamics.motion import Motion
from recordings.recording import Floats, Ints
from recordings.rig import Rig

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
_SAMPLED = 20
"""Number of instants whose natural frequencies are computed."""


def impossible(rig: Rig, joint: int) -> str | None:
    """Tell that loops hold the joints: their torque takes too long to be differentiated in every fit."""
    return "The arms of closed loops are not simulated behind springs and gaps." if rig.loops else None


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Derivatives (m, dof, dof) of the arms' torque along a motion of n instants, at some of these."""

    instants: Floats
    """(m,) numbers of the instants."""
    stiffness: Floats
    """K, by position [N m/rad]: column j by joint j."""
    damping: Floats
    """C, by velocity [N m s/rad]."""
    inertia: Floats
    """M, by acceleration [kg m^2]: the inertia matrix."""

    @classmethod
    def along(cls, motion: Motion, torque: Callable[[Motion], Floats], step: int) -> "Derivatives":
        """Compute them from what gives the `torque` (n, dof) along any motion, at every `step`-th known instant."""
        state = np.stack([motion.position, motion.velocity, motion.acceleration], axis=1)
        known = np.flatnonzero(np.isfinite(state).all(axis=(1, 2)))[::step]
        instants = known if len(known) else np.zeros(1, int)
        dof = state.shape[2]
        shifts = np.concatenate([np.zeros((1, 3 * dof)), _DIFFERENCE * np.eye(3 * dof)])
        # The variants of an instant follow each other: loops are closed from one row to the next.
        varied = (state[instants, None] + shifts.reshape(-1, 3, dof)).reshape(-1, 3, dof)
        position, velocity, acceleration = np.ascontiguousarray(varied.transpose(1, 0, 2))
        torques = torque(Motion(position, velocity, acceleration, np.zeros_like(velocity)))
        torques = torques.reshape(len(instants), -1, dof)
        slopes = np.nan_to_num((torques[:, 1:] - torques[:, :1]) / _DIFFERENCE)
        return cls(instants.astype(float), *np.split(slopes.transpose(0, 2, 1), 3, axis=2))

    def at_all(self, n: int, joints: Ints) -> Floats:
        """K, C and M (3, n, dof, f) at all `n` instants, by linear interpolation, for the columns `joints` (f,)."""
        chosen = np.stack([self.stiffness, self.damping, self.inertia], axis=1)[..., joints]
        series = [np.interp(np.arange(n), self.instants, each) for each in chosen.reshape(len(chosen), -1).T]
        return np.moveaxis(np.reshape(series, (*chosen.shape[1:], n)), 3, 1)

    @property
    def smallest_inertia(self) -> Floats:
        """(dof,) smallest inertia of each joint along the motion, the others at rest [kg m^2]; 0 if negative."""
        return np.diagonal(self.inertia, axis1=1, axis2=2).min(axis=0, initial=np.inf).clip(0.0)

    def without_motors(self, inertias: Floats) -> "Derivatives":
        """Return those of arms without motors that have these `inertias` (dof,)."""
        return replace(self, inertia=self.inertia - np.diag(inertias))


@dataclass(frozen=True, eq=False)
class FlexibleJoints:
    """Arms of a robot along a motion of their motors, of n instants."""

    torque: Floats
    """(n, dof) that moves the arms if they follow the motors [N m]; NaN where unknown."""
    derivatives: Derivatives
    rate: float
    """Sampling rate of the motion [Hz]."""

    def change_by_springs(self, compliance: Floats, damping_ratio: float) -> Floats:
        """Change (n, dof) of the torque by springs that connect motors and arms.

        compliance: (dof,), 0 for a stiff joint; damping_ratio: damping over critical damping.
        """
        from ident.dynamics.elastic_kernel import spring_twists

        joints = np.flatnonzero(compliance > 0)
        torque, columns = self._of(joints)
        K, C, M = (np.ascontiguousarray(each[:, joints]) for each in columns)
        diagonal, c = np.arange(len(joints)), compliance[joints]
        K[:, diagonal, diagonal] += 1 / c
        C[:, diagonal, diagonal] += 2 * damping_ratio * np.sqrt(M[:, diagonal, diagonal].clip(0.0) / c)
        phase = self.natural_frequencies(compliance).max(initial=0.0) / self.rate
        substeps = int(np.clip(np.ceil(phase / _PHASE_STEP), 1, _MAX_SUBSTEPS))
        beta = 1 / 12 if phase < _RESOLVED * substeps else 1 / 4
        return _change(columns, spring_twists(torque, K, C, M, 1 / self.rate, substeps, beta))

    def change_by_backlash(self, half_gap: Floats, impact_delay: float = 0.0) -> Floats:
        """Change (n, dof) of the torque by arms that move by +-`half_gap` (dof,) against their motors.

        impact_delay: time from the contact to the middle of the impact [s].
        """
        from ident.dynamics.backlash_kernel import backlash_twists

        joints = np.flatnonzero(half_gap > 0)
        torque, columns = self._of(joints)
        arms = (np.ascontiguousarray(each[:, joints]) for each in columns)
        substeps = int(np.ceil(1 / (self.rate * _BACKLASH_STEP)))
        twists = backlash_twists(torque, *arms, half_gap[joints], _IMPACT, impact_delay, 1 / self.rate, substeps)
        return _change(columns, twists)

    def cost_reductions(
        self, motor_torque: Floats, joint_inertias: Floats, residual: Floats, motor_shares: Floats, half_gaps: Floats
    ) -> Floats:
        """Estimate the reductions (s, h, dof) of the sum of squares of a `residual` (n, dof) [N m] by backlash.

        Each joint is treated alone. These arms must have the whole `joint_inertias` (dof,) [kg m^2], of which the
        `motor_shares` (s,) are taken away, with their torque `motor_torque` (n, dof); half_gaps: (h,) [rad or m].
        """
        from ident.dynamics.backlash_screening import cost_reductions

        gradient, _, inertia = np.diagonal(self._of(np.arange(len(joint_inertias)))[1], axis1=2, axis2=3)
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

    def _of(self, joints: Ints) -> tuple[Floats, Floats]:
        """Torque (n, f) of these `joints` (f,), NaN where that of any is, and columns (3, n, dof, f) of K, C, M."""
        known = np.isfinite(self.torque).all(axis=1, keepdims=True)
        torque = np.where(known, self.torque, np.nan)[:, joints]
        return torque, self.derivatives.at_all(len(torque), joints)

    def natural_frequencies(self, compliance: Floats) -> Floats:
        """Natural frequencies (s,) [rad/s] of the joints whose `compliance` (dof,) is positive, at some instants."""
        soft = np.flatnonzero(compliance > 0)
        root = np.sqrt(compliance[soft])
        step = max(1, len(self.derivatives.inertia) // _SAMPLED)
        squares = root[:, None] * self.derivatives.inertia[::step, soft[:, None], soft] * root
        return 1 / np.sqrt(np.linalg.eigvalsh(squares).clip(1e-12)).ravel()


def _change(columns: Floats, twists: Floats) -> Floats:
    """- K x - C x' - M x'' (n, dof), with `columns` (3, n, dof, f) of K, C, M and `twists` (3, n, f), x and so on."""
    return -np.einsum("dnjf,dnf->nj", columns, twists)
