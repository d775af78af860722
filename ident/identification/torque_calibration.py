"""Calibrate torque gains by two recordings of one motion, without and with a known payload.

The torque of the payload is known in N m: J' m (P_ddot - g), Eqs. (16), (23), (26). The torque computed with the
assumed gains is the true torque times assumed / true gain, so comparing both determines the true gain:

    measured_j = scale_j (Y_j beta + m Y_j,p),    gain_j = assumed gain_j / scale_j,

with the rows Y_j of the regressor and its column p of the platform's mass. The noise is on the left, as least
squares requires. All joints of both recordings are fitted together. Masses, inertias and gravity are shared; friction
is free in each recording, because it changes with temperature and load; each joint has a scale.

The motion must be the same in both recordings, so that model errors are the same and cancel. With different motions,
on a robot whose rods are not point masses, gains were 5 % too large; with the same motion they were within 0.1 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ident.data import noise
from ident.data.compatibility import check_same_rig
from ident.data.prepared_recording import PreparedRecording, prepare_all
from ident.uncertainty import covariance
from ident.uncertainty.covariance import Uncertainty
from ident.uncertainty.sensitivity import LENGTH_STEP, with_longer_rods
from recordings.errors import BadInput
from recordings.recording import Floats, Ints, Recording
from recordings.rig import Torque

PAYLOAD_PARAMETERS = {"delta": "m_p"}
"""Mechanisms that can carry a payload, with the parameter that the payload adds to."""
MIN_EXPLAINED = 0.9
"""Minimum share of the difference between the recordings that the payload explains."""
MAX_RELATIVE_STD = 0.2
"""Maximum relative standard error of a gain."""
SIGNIFICANCE_LEVEL = 0.01
_CONVERGED = 1e-10


@dataclass(frozen=True, eq=False)
class Calibration:
    """Calibrated gains of n joints."""

    torque: Torque
    """Section [torque] of the rig file."""
    intervals: Floats
    """(n, 2) 95 % intervals of the gains, given the payload and the geometry."""
    relative_std: Floats
    """(n,) relative standard errors."""
    explained: float
    """Share of the difference between the recordings that the payload explains, 0 to 1."""
    spread: float
    """Largest gain over smallest gain, minus 1."""
    equal_p: float
    """p-value of the hypothesis that all joints have the same gain."""
    per_length_step: Floats
    """(n,) relative change of the gains if L2 is longer by LENGTH_STEP."""

    @property
    def gains_differ(self) -> bool:
        """True if the gains differ significantly between joints."""
        return self.equal_p < SIGNIFICANCE_LEVEL


def calibrate(empty: Recording, loaded: Recording, payload: float, method: str = "parallel") -> Calibration:
    """Estimate gains from the recordings `empty` and `loaded`, which differ by `payload` [kg].

    method: preprocessing.

    Raises:
        BadInput: the recordings are not of one rig and motion, the mechanism carries no payload, or the payload does
            not explain the difference between them.
    """
    _check_recordings(empty, loaded, payload)
    prepared = prepare_all([empty, loaded], method, None)
    problem = _CalibrationProblem.of(prepared, payload)
    solution = problem.solve()
    error = problem.uncertainty(prepared, solution)
    scale, scales = solution[-problem.dof :], slice(-problem.dof, None)
    relative = error.std[scales] / np.abs(scale)
    _check_scales(scale, error.half_width()[scales], loaded, payload)
    explained = problem.explained()
    _check_explained(relative, explained, empty, loaded, payload)
    gain = np.array(empty.rig.torque.gain) / scale
    width = gain * error.half_width()[scales] / scale
    return Calibration(
        torque=empty.rig.torque.model_copy(
            update={
                "gain": tuple(float(value) for value in gain),
                "gain_source": "calibrated",
                "gain_uncertainty": float(relative.max()),
            }
        ),
        intervals=np.stack([gain - width, gain + width], axis=1),
        relative_std=relative,
        explained=explained,
        spread=float(gain.max() / gain.min() - 1),
        equal_p=_equal_p(gain, error.covariance[scales, scales] * np.outer(gain / scale, gain / scale)),
        per_length_step=_per_length_step(empty, loaded, payload, method),
    )


@dataclass(frozen=True, eq=False)
class _CalibrationProblem:
    """Regression problem of both recordings, with r usable joint samples and no NaN."""

    columns: Floats
    """(r, k) regressor, with separate friction columns for each recording."""
    payload_torque: Floats
    """(r,) torque of the payload [N m]; zero without payload."""
    measured: Floats
    """(r,) torque computed with the assumed gains [N m]."""
    joint: Ints
    """(r,) index of the joint."""
    dof: int

    @classmethod
    def of(cls, recordings: Sequence[PreparedRecording], payload: float) -> "_CalibrationProblem":
        parameters = recordings[0].mechanism.parameters
        friction = np.array([parameter.friction for parameter in parameters])
        mass = [parameter.name for parameter in parameters].index(
            PAYLOAD_PARAMETERS[recordings[0].recording.rig.mechanism]
        )
        columns, payload_torque = [], []
        for number, prepared in enumerate(recordings):
            own_friction = prepared.regressor[:, :, friction]
            all_friction = [
                own_friction if i == number else np.zeros_like(own_friction) for i in range(len(recordings))
            ]
            columns.append(np.concatenate([prepared.regressor[:, :, ~friction], *all_friction], axis=2))
            payload_torque.append(number * payload * prepared.regressor[:, :, mass])
        measured = np.concatenate([prepared.torque for prepared in recordings])
        usable = np.isfinite(measured)
        joint = np.broadcast_to(np.arange(measured.shape[1]), measured.shape)
        return cls(
            np.concatenate(columns)[usable],
            np.concatenate(payload_torque)[usable],
            measured[usable],
            joint[usable],
            measured.shape[1],
        )

    def solve(self) -> Floats:
        """(k + dof,) parameters and scales by nonlinear least squares.

        The initial scales are fitted joint by joint, which is a linear problem: scale_j beta and scale_j are unknown.
        """
        from scipy.optimize import least_squares

        def residual(x: Floats) -> Floats:
            return self.model(x[: -self.dof], x[-self.dof :]) - self.measured

        def jacobian(x: Floats) -> Floats:
            return self.jacobian(x[: -self.dof], x[-self.dof :])

        start = [self._fit_joint(joint)[0] for joint in range(self.dof)]
        return least_squares(
            residual,
            np.concatenate([np.zeros(self.columns.shape[1]), start]),
            jacobian,
            method="lm",
            x_scale="jac",
            xtol=_CONVERGED,
        ).x

    def model(self, parameters: Floats, scale: Floats) -> Floats:
        """(r,) predicted torque, on the scale of the assumed gains [N m]."""
        return scale[self.joint] * (self.columns @ parameters + self.payload_torque)

    def jacobian(self, parameters: Floats, scale: Floats) -> Floats:
        """(r, k + dof) derivatives of the predicted torque with respect to parameters and scales."""
        torque = self.columns @ parameters + self.payload_torque
        of_joint = self.joint[:, None] == np.arange(self.dof)
        return np.concatenate([scale[self.joint, None] * self.columns, of_joint * torque[:, None]], axis=1)

    def uncertainty(self, recordings: Sequence[PreparedRecording], solution: Floats) -> Uncertainty:
        """Uncertainty of the solution."""
        parameters, scale = solution[: -self.dof], solution[-self.dof :]
        residuals = self._by_recording(self.measured - self.model(parameters, scale), recordings)
        jacobian = self._by_recording(self.jacobian(parameters, scale), recordings)
        joint_noise = noise.estimate(recordings, residuals)
        blocks = [
            covariance.least_squares(
                rows, residual, noise.residual_std(prepared, residual, joint_noise), prepared.repeat
            )
            for prepared, rows, residual in zip(recordings, jacobian, residuals, strict=True)
        ]
        return covariance.estimate(blocks)

    def explained(self) -> float:
        """Reduction of the sum of squares by the payload, over that by separate parameters for each recording."""
        without, with_payload, separate = np.sum([self._fit_joint(joint)[1] for joint in range(self.dof)], axis=0)
        return float((without - with_payload) / (without - separate)) if without > separate else 0.0

    def _fit_joint(self, joint: int) -> tuple[float, Floats]:
        """Scale of one joint fitted alone; sums of squares without payload, with it, and with separate parameters."""
        rows = self.joint == joint
        columns, payload_torque, measured = self.columns[rows], self.payload_torque[rows, None], self.measured[rows]
        separate = np.concatenate([columns, columns * (payload_torque != 0)], axis=1)
        designs = (columns, np.concatenate([columns, payload_torque], axis=1), separate)
        solutions = [np.linalg.lstsq(design, measured, rcond=None)[0] for design in designs]
        residuals = [measured - design @ solution for design, solution in zip(designs, solutions, strict=True)]
        return float(solutions[1][-1]), np.array([residual @ residual for residual in residuals])

    def _by_recording(self, x: Floats, recordings: Sequence[PreparedRecording]) -> list[Floats]:
        """Rearrange rows `x` (r, ...) to (m, dof, ...) for each recording; NaN where a sample is not usable."""
        usable = np.isfinite(np.concatenate([prepared.torque for prepared in recordings]))
        full = np.full((*usable.shape, *x.shape[1:]), np.nan)
        full[usable] = x
        return np.split(full, np.cumsum([len(prepared.torque) for prepared in recordings])[:-1])


def _equal_p(gain: Floats, covariance: Floats) -> float:
    """p-value of Wald's test of equal gains (n,)."""
    from scipy.stats import chi2

    if len(gain) == 1:
        return 1.0
    contrasts = np.eye(len(gain))[1:] - np.eye(len(gain))[0]
    difference = contrasts @ gain
    statistic = difference @ np.linalg.solve(contrasts @ covariance @ contrasts.T, difference)
    return float(chi2.sf(statistic, len(difference)))


def _per_length_step(empty: Recording, loaded: Recording, payload: float, method: str) -> Floats:
    scales = []
    for step in (-LENGTH_STEP, LENGTH_STEP):
        pair = [with_longer_rods(recording, step) for recording in (empty, loaded)]
        prepared = prepare_all(pair, method, None)
        problem = _CalibrationProblem.of(prepared, payload)
        scales.append(problem.solve()[-problem.dof :])
    shorter, longer = scales
    return (shorter / longer - longer / shorter) / 4


def _check_recordings(empty: Recording, loaded: Recording, payload: float) -> None:
    if not payload > 0:
        raise BadInput(f"a payload above 0 kg expected, {payload:g} kg found; give the added mass")
    check_same_rig([empty, loaded], own_gains=False)
    if empty.rig.mechanism not in PAYLOAD_PARAMETERS:
        raise BadInput(
            f"a mechanism that carries a payload expected ({', '.join(PAYLOAD_PARAMETERS)}), {empty.rig.mechanism} "
            "found; measure its gain by another method"
        )
    first, second = empty.run, loaded.run
    if first.trajectory_digest != second.trajectory_digest:
        raise BadInput(
            f"the same motion in both recordings expected, {first.trajectory} in {empty.path.name} and "
            f"{second.trajectory} in {loaded.path.name} found; record {first.trajectory} with the payload"
        )


def _check_scales(scale: Floats, width: Floats, loaded: Recording, payload: float) -> None:
    if (scale < -width).all():
        raise BadInput(
            f"the payload of {payload:g} kg in the second recording expected, but the robot is lighter there; "
            "exchange the two files"
        )
    for joint in np.flatnonzero(scale <= width):
        raise BadInput(
            f"{loaded.path.name}: a payload of {payload:g} kg expected, but joint {joint + 1} shows none; check that "
            "it was mounted, or use a heavier payload"
        )


def _check_explained(relative: Floats, explained: float, empty: Recording, loaded: Recording, payload: float) -> None:
    names = f"{empty.path.name} and {loaded.path.name}"
    if explained < MIN_EXPLAINED:
        raise BadInput(
            f"{names}: two recordings that differ by a payload expected, but it explains only "
            f"{100 * max(explained, 0):.0f} % of their difference; change nothing else between them"
        )
    if relative.max() > MAX_RELATIVE_STD:
        raise BadInput(
            f"{names}: gains known to better than {100 * MAX_RELATIVE_STD:.0f} % expected, joint "
            f"{int(relative.argmax()) + 1} is known to {100 * relative.max():.0f} % with {payload:g} kg; use a "
            "heavier payload or record longer"
        )
