"""Arms that are coupled to their motors by springs or through backlash, simulated along the motors' motion.

The compiled kernels are loaded when they are first needed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ident.dynamics import mechanisms
from ident.dynamics.mechanisms.urdf import Urdf
from ident.dynamics.motion import Motion
from ident.dynamics.platform import kernel_constants
from recordings.recording import Floats
from recordings.rig import Rig
from recordings.urdf import Vector

_KINDS = ("axes", "delta", "urdf")
"""Mechanisms by the numbers that the kernels know."""
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
"""Change of an arm's position for a finite difference [rad or m]."""
_DIVERGED = 1e3
"""Largest change of the torque, over the largest torque: beyond it, the simulation has no stable solution."""
_STATES = 100
"""Number of poses among which the inertia of a joint of a tree of links is smallest."""


def impossible(rig: Rig, joint: int) -> str | None:
    """Joints of a URDF that follow others, in loops or by `<mimic>`, are unknown to the compiled kernels."""
    if rig.mechanism == "urdf" and rig.following:
        return "Arms with closed loops or mimic joints are not simulated behind springs and gaps."
    return None


@dataclass(frozen=True, eq=False)
class FlexibleJoints:
    """Arms of a robot, in the form that the compiled kernels take."""

    mechanism: str
    constants: Floats
    """Lengths, angles and inertial parameters, in the order of the kernels."""
    rate: float
    """Sampling rate of the motions [Hz]."""
    load: Floats | None = None
    """Further torque (n, dof) [N m] of the arms along the motion with which it is used; None: there is none."""

    def rigid_torque(self, motion: Motion) -> Floats:
        """Torque (n, dof) [N m] of the arms if they follow the motors."""
        from ident.dynamics.arm_kernels import dynamics_along

        return dynamics_along(self._kind, self.constants, *_contiguous(motion))[0] + self._load_along(motion)

    def elastic_torque(self, motion: Motion, compliance: Floats, damping_ratio: float) -> Floats:
        """Torque (n, dof) [N m] of the springs that connect motors and arms.

        compliance: (dof,), 0 for a stiff joint; damping_ratio: damping over critical damping.
        """
        from ident.dynamics.elastic_kernel import elastic_torque

        phase, beta = self.natural_frequencies(motion, compliance) / self.rate, np.full(len(compliance), 1 / 4)
        most = 1 if self.mechanism == "urdf" else _MAX_SUBSTEPS
        substeps = int(np.clip(np.ceil(phase.max(initial=0.0) / _PHASE_STEP), 1, most))
        if len(phase):
            beta[compliance > 0] = np.where(phase < _RESOLVED * substeps, 1 / 12, 1 / 4)
        return elastic_torque(
            self._kind,
            self.constants,
            *_contiguous(motion),
            self._load_along(motion),
            compliance,
            damping_ratio,
            1 / self.rate,
            substeps,
            beta,
        )

    def backlash_torque(self, motion: Motion, half_gap: Floats, impact_delay: float = 0.0) -> Floats:
        """Torque (n, dof) [N m] between motors and arms that move by +-`half_gap` (dof,) against them.

        impact_delay: time from the contact to the middle of the impact [s].
        """
        from ident.dynamics.backlash_kernel import backlash_torque

        substeps = int(np.ceil(1 / (self.rate * _BACKLASH_STEP)))
        return backlash_torque(
            self._kind,
            self.constants,
            *_contiguous(motion),
            self._load_along(motion),
            half_gap,
            _IMPACT,
            impact_delay,
            1 / self.rate,
            substeps,
        )

    def cost_reductions(
        self, motion: Motion, joint_inertias: Floats, residual: Floats, motor_shares: Floats, half_gaps: Floats
    ) -> Floats:
        """Estimate the reductions (s, h, dof) of the sum of squares of a `residual` (n, dof) [N m] by backlash.

        Each joint is treated alone. These arms must have the whole `joint_inertias` (dof,) [kg m^2], with which the
        `motor_shares` (s,) are multiplied; half_gaps: (h,) [rad or m].
        """
        from ident.dynamics.arm_kernels import dynamics_along
        from ident.dynamics.backlash_screening import cost_reductions

        position, velocity, acceleration = _contiguous(motion)
        load, inertia = dynamics_along(self._kind, self.constants, position, velocity, acceleration)
        gradient = np.empty_like(load)
        for joint, offset in enumerate(_DIFFERENCE * np.eye(load.shape[1])):
            shifted = dynamics_along(self._kind, self.constants, position - offset, velocity, acceleration)[0]
            gradient[:, joint] = (shifted[:, joint] - load[:, joint]) / _DIFFERENCE
        load += self._load_along(motion)
        motor_torque = joint_inertias * motion.acceleration
        substeps = int(np.ceil(1 / (self.rate * _SCREENING_STEP)))
        return cost_reductions(
            load,
            gradient,
            inertia,
            motor_torque,
            joint_inertias,
            residual,
            motor_shares,
            half_gaps,
            1 / self.rate,
            substeps,
        )

    @property
    def _kind(self) -> int:
        return _KINDS.index(self.mechanism)

    def _load_along(self, motion: Motion) -> Floats:
        return np.zeros_like(motion.position) if self.load is None else np.ascontiguousarray(self.load)

    def natural_frequencies(self, motion: Motion, compliance: Floats) -> Floats:
        """Approximate natural frequencies (s,) [rad/s] of the joints whose `compliance` (dof,) is positive."""
        from ident.dynamics.arm_kernels import dynamics_along

        known, soft = np.isfinite(motion.acceleration).all(axis=1), compliance > 0
        if not known.any():
            return np.empty(0)
        first = slice(np.argmax(known), np.argmax(known) + 1)
        inertia = dynamics_along(self._kind, self.constants, *(signal[first] for signal in _contiguous(motion)))[1][
            0, soft
        ]
        return np.sqrt(1 / (compliance[soft] * np.maximum(inertia, 1e-9)))


def flexible_joints(
    rig: Rig,
    parameters: Mapping[str, float],
    share: float,
    rate: float,
    load: Floats | None = None,
    masses: Sequence[tuple[float, Vector]] = (),
) -> FlexibleJoints:
    """Return the arms of `rig` with a mechanism's `parameters` by name; motors have a `share` of joint inertia.

    load: further torque (n, dof) [N m] of the arms along the motion with which they are used. masses: further ones
        [kg] that they carry, and their places [m].
    """
    inertia = joint_inertia(rig, parameters)
    if rig.mechanism == "urdf":
        constants = _of_links(rig, parameters, masses)
        constants[: rig.dof**2 : rig.dof + 1] -= share * inertia
        return FlexibleJoints("urdf", constants, rate, load)
    inertia = inertia * (1 - share)
    if rig.mechanism == "delta":
        m_p = parameters["m_p"] + sum(mass for mass, _ in masses)
        of_arms = (max(m_p, 0.0), parameters["T_g"], max(parameters.get("m_d", 0.0), 0.0))
        return FlexibleJoints("delta", kernel_constants(rig.geometry, of_arms, inertia), rate, load)
    joints = range(1, rig.dof + 1)
    weight = [[parameters.get(f"{name}{j}", 0.0) for j in joints] for name in ("G_c", "G_s", "G_")]
    return FlexibleJoints("axes", np.stack([inertia, *weight]).ravel() + _of_masses(rig, masses), rate, load)


def _of_masses(rig: Rig, masses: Sequence[tuple[float, Vector]]) -> Floats:
    """Constants (4 dof,) of independent axes of which the last one carries `masses` [kg] at their places [m]."""
    still, last = np.zeros((3, rig.dof)), rig.dof - 1
    position, acceleration = still.copy(), still.copy()
    position[1, last], acceleration[2, last] = np.pi / 2, 1.0
    across, along, moved = mechanisms.torque_of_masses(
        mechanisms.create(rig), masses, Motion(position, still, acceleration, still)
    )[:, last]
    constants = np.zeros((4, rig.dof))
    weights = (0, 0, across) if rig.joint_types[last] == "prismatic" else (across, along, 0)
    constants[:, last] = moved - across, *weights
    return constants.ravel()


def change_of_torque(soft: Floats, stiff: Floats) -> Floats:
    """Return what springs or gaps change of the torque (n, dof) of `stiff` joints, 0 where it is unknown or diverges.

    soft: (n, dof) torque with springs or gaps [N m].
    """
    change = soft - stiff
    return np.where(np.abs(change) < _DIVERGED * np.nanmax(np.abs(stiff), initial=0.0), change, 0.0)


def joint_inertia(rig: Rig, parameters: Mapping[str, float]) -> Floats:
    """Own inertia (dof,) of each joint, arm and motor [kg m^2 or kg]; 0 where the estimate is negative.

    Of a tree of links it is the smallest in any pose, the other joints at rest: any share of it leaves some to links.
    """
    if rig.mechanism == "urdf":
        from ident.dynamics.arm_kernels import dynamics_along

        states = np.random.default_rng(0).uniform(-np.pi, np.pi, (3, _STATES, rig.dof))
        inertia = dynamics_along(_KINDS.index("urdf"), _of_links(rig, parameters), *states)[1]
        return np.asarray(inertia.min(axis=0).clip(0.0))
    inertias = (parameters.get(f"I_{j}", parameters.get(f"m_{j}", 0.0)) for j in range(1, rig.dof + 1))
    return np.array([max(inertia, 0.0) for inertia in inertias])


def _of_links(rig: Rig, parameters: Mapping[str, float], masses: Sequence[tuple[float, Vector]] = ()) -> Floats:
    mechanism = mechanisms.create(rig)
    assert isinstance(mechanism, Urdf)
    return mechanism.kernel_constants(np.array([parameters[each.name] for each in mechanism.parameters]), masses)


def _contiguous(motion: Motion) -> tuple[Floats, Floats, Floats]:
    signals = (motion.position, motion.velocity, motion.acceleration)
    position, velocity, acceleration = (np.ascontiguousarray(signal) for signal in signals)
    return position, velocity, acceleration
