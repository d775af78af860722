"""Torque gains from two recordings of one motion, without and with a known payload.

What the payload adds to the torque is known in N m: J' m (P_ddot - g), Eqs. (16), (23), (26). So the torque that the
assumed gains give, which is the true one times assumed / true gain, tells the true gain:

    measured_j = scale_j (Y_j beta + m Y_j,p),    gain_j = assumed gain_j / scale_j,

with the rows Y_j of the regressor and its column p of the platform's mass. The noise is on the left, where least
squares wants it. All joints of both recordings are fitted together: what cannot have changed is shared (masses,
inertias, gravity), friction is free in each recording (it warms up, and rises with load), each joint has a scale.

The motion must be the same in both, so that what the model lacks is too, and cancels: with another motion, on a robot
whose forearms are no point masses, gains came out 5 % too large; with the same, within 0.1 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ident.data import noise
from ident.data.compatibility import check_same_rig
from ident.data.dataset import Dataset, build_all
from ident.dynamics import mechanisms
from ident.uncertainty import covariance
from ident.uncertainty.covariance import Uncertainty
from ident.uncertainty.sensitivity import LENGTH_STEP, with_longer_rods
from recordings.errors import BadInput
from recordings.recording import Floats, Ints, Recording
from recordings.rig import Torque

PAYLOAD_PARAMETERS = {"delta": "m_p"}
"""Of each mechanism that can carry a payload, the parameter that it adds to."""
MIN_EXPLAINED = 0.9
"""Of what differs between the recordings, the payload must explain this share."""
MAX_RELATIVE_STD = 0.2
"""A gain known no better than this (relative standard error) is not worth having."""
SIGNIFICANCE_LEVEL = 0.01
_STEPS = 20
_CONVERGED = 1e-10


@dataclass(frozen=True, eq=False)
class Calibration:
    """Gains of n joints."""

    torque: Torque
    """As it belongs into the rig file."""
    intervals: Floats
    """(n, 2) of the gains, 95 %, given the payload and the geometry."""
    relative_std: Floats
    """(n,) relative standard errors."""
    explained: float
    """Share of the difference between the recordings that is what the payload does, 0 to 1."""
    spread: float
    """Largest gain over smallest, minus 1."""
    equal_p: float
    """Probability of such differences if all joints had the same gain."""
    per_length_step: Floats
    """(n,) relative change of the gains where L2 is longer by LENGTH_STEP."""

    @property
    def gains_differ(self) -> bool:
        """Whether the gains differ between joints by more than chance."""
        return self.equal_p < SIGNIFICANCE_LEVEL


def calibrate(empty: Recording, loaded: Recording, payload: float, method: str = "parallel") -> Calibration:
    """The gains from the recordings `empty` and `loaded`, which differ by `payload` [kg], preprocessed by `method`.

    Raises:
        BadInput: the recordings are not of one rig and motion, the mechanism carries no payload, or the difference
            between them is not what the payload would do.
    """
    _refuse_unlike(empty, loaded, payload)
    datasets = build_all([empty, loaded], mechanisms.create(empty.rig), method, None)
    problem = _Problem.of(datasets, payload)
    solution = problem.solve()
    error = problem.uncertainty(datasets, solution)
    scale, scales = solution[-problem.dof :], slice(-problem.dof, None)
    relative = error.std[scales] / np.abs(scale)
    _refuse_backwards(scale, error.half_width()[scales], loaded, payload)
    explained = problem.explained()
    _refuse_unexplained(relative, explained, empty, loaded, payload)
    gain = np.array(empty.rig.torque.gain) / scale
    width = gain * error.half_width()[scales] / scale
    return Calibration(
        torque=empty.rig.torque.model_copy(
            update={
                "gain": tuple(float(one) for one in gain),
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
class _Problem:
    """Both recordings side by side: r usable joint samples; NaN nowhere."""

    columns: Floats
    """(r, k) regressor, with friction of each recording in columns of its own."""
    carried: Floats
    """(r,) what the payload adds to the torque [N m]; zero without it."""
    measured: Floats
    """(r,) torque by the assumed gains [N m]."""
    joint: Ints
    """(r,)."""
    dof: int

    @classmethod
    def of(cls, datasets: Sequence[Dataset], payload: float) -> "_Problem":
        names = mechanisms.create(datasets[0].recording.rig).parameters
        friction = np.array([parameter.friction for parameter in names])
        mass = [parameter.name for parameter in names].index(PAYLOAD_PARAMETERS[datasets[0].recording.rig.mechanism])
        columns, carried = [], []
        for number, dataset in enumerate(datasets):
            rubbing = dataset.regressor[:, :, friction]
            both = [rubbing if other == number else np.zeros_like(rubbing) for other in range(len(datasets))]
            columns.append(np.concatenate([dataset.regressor[:, :, ~friction], *both], axis=2))
            carried.append(number * payload * dataset.regressor[:, :, mass])
        measured = np.concatenate([dataset.torque for dataset in datasets])
        usable = np.isfinite(measured)
        joint = np.broadcast_to(np.arange(measured.shape[1]), measured.shape)
        return cls(
            np.concatenate(columns)[usable],
            np.concatenate(carried)[usable],
            measured[usable],
            joint[usable],
            measured.shape[1],
        )

    def solve(self) -> Floats:
        """(k + dof,) parameters and scales that leave the least sum of squares, by Gauss-Newton.

        It starts from scales found joint by joint, which is a linear problem: scale_j beta and scale_j are unknown.
        """
        scale = np.array([self._alone(joint)[0] for joint in range(self.dof)])
        parameters = np.zeros(self.columns.shape[1])
        for _ in range(_STEPS):
            jacobian = self.jacobian(parameters, scale)
            left = self.measured - self.model(parameters, scale)
            step = np.linalg.lstsq(jacobian, left, rcond=None)[0]
            parameters, scale = parameters + step[: -self.dof], scale + step[-self.dof :]
            if np.abs(step).max() < _CONVERGED * np.abs(scale).max():
                break
        return np.concatenate([parameters, scale])

    def model(self, parameters: Floats, scale: Floats) -> Floats:
        """(r,) torque by the assumed gains [N m]."""
        torque: Floats = scale[self.joint] * (self.columns @ parameters + self.carried)
        return torque

    def jacobian(self, parameters: Floats, scale: Floats) -> Floats:
        """(r, k + dof)."""
        torque = self.columns @ parameters + self.carried
        own = self.joint[:, None] == np.arange(self.dof)
        return np.concatenate([scale[self.joint, None] * self.columns, own * torque[:, None]], axis=1)

    def uncertainty(self, datasets: Sequence[Dataset], solution: Floats) -> Uncertainty:
        """Of the solution."""
        parameters, scale = solution[: -self.dof], solution[-self.dof :]
        residual = self._spread_out(self.measured - self.model(parameters, scale), datasets)
        jacobian = self._spread_out(self.jacobian(parameters, scale), datasets)
        found = noise.estimate(datasets, residual)
        parts = [
            covariance.least_squares(rows, left, noise.residual_std(dataset, left, found), dataset.repeat)
            for dataset, rows, left in zip(datasets, jacobian, residual, strict=True)
        ]
        return covariance.estimate(parts)

    def explained(self) -> float:
        """How much of what another set of parameters for the second recording would explain, the payload does."""
        without, by_payload, freely = np.sum([self._alone(joint)[1] for joint in range(self.dof)], axis=0)
        return float((without - by_payload) / (without - freely)) if without > freely else 0.0

    def _alone(self, joint: int) -> tuple[float, Floats]:
        """Scale of one joint by itself; sums of squares without payload, with it, and with all parameters apart."""
        own = self.joint == joint
        columns, carried, measured = self.columns[own], self.carried[own, None], self.measured[own]
        apart = np.concatenate([columns, columns * (carried != 0)], axis=1)
        designs = (columns, np.concatenate([columns, carried], axis=1), apart)
        solutions = [np.linalg.lstsq(design, measured, rcond=None)[0] for design in designs]
        left = [measured - design @ solution for design, solution in zip(designs, solutions, strict=True)]
        return float(solutions[1][-1]), np.array([residual @ residual for residual in left])

    def _spread_out(self, x: Floats, datasets: Sequence[Dataset]) -> list[Floats]:
        """Rows `x` (r, ...) as (m, dof, ...) for each data set; NaN where a sample is not usable."""
        usable = np.isfinite(np.concatenate([dataset.torque for dataset in datasets]))
        full = np.full((*usable.shape, *x.shape[1:]), np.nan)
        full[usable] = x
        return np.split(full, np.cumsum([len(dataset.torque) for dataset in datasets])[:-1])


def _equal_p(gain: Floats, covariance: Floats) -> float:
    """Wald's test of equal gains (n,)."""
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
        datasets = build_all(pair, mechanisms.create(pair[0].rig), method, None)
        problem = _Problem.of(datasets, payload)
        scales.append(problem.solve()[-problem.dof :])
    shorter, longer = scales
    change: Floats = (shorter / longer - longer / shorter) / 4
    return change


def _refuse_unlike(empty: Recording, loaded: Recording, payload: float) -> None:
    if not payload > 0:
        raise BadInput(f"a payload above 0 kg expected, {payload:g} kg found; give the mass that was added")
    check_same_rig([empty, loaded])
    if empty.rig.mechanism not in PAYLOAD_PARAMETERS:
        raise BadInput(
            f"a mechanism that carries a payload expected ({', '.join(PAYLOAD_PARAMETERS)}), {empty.rig.mechanism} found; "
            "measure its gain otherwise"
        )
    one, other = empty.run, loaded.run
    if one.trajectory_digest != other.trajectory_digest:
        raise BadInput(
            f"the same motion in both recordings expected, {one.trajectory} in {empty.path.name} and "
            f"{other.trajectory} in {loaded.path.name} found; record {one.trajectory} with the payload"
        )


def _refuse_backwards(scale: Floats, width: Floats, loaded: Recording, payload: float) -> None:
    if (scale < -width).all():
        raise BadInput(
            f"the payload of {payload:g} kg in the second recording expected, but there the robot is lighter; "
            "exchange the two files"
        )
    for joint in np.flatnonzero(scale <= width):
        raise BadInput(
            f"{loaded.path.name}: a payload of {payload:g} kg expected, but joint {joint + 1} shows none; check that "
            "it was carried, or take a heavier one"
        )


def _refuse_unexplained(
    relative: Floats, explained: float, empty: Recording, loaded: Recording, payload: float
) -> None:
    names = f"{empty.path.name} and {loaded.path.name}"
    if explained < MIN_EXPLAINED:
        raise BadInput(
            f"{names}: two recordings that differ by a payload expected, but it explains only "
            f"{100 * max(explained, 0):.0f} % of how they differ; change nothing else between them"
        )
    if relative.max() > MAX_RELATIVE_STD:
        raise BadInput(
            f"{names}: gains known to better than {100 * MAX_RELATIVE_STD:.0f} % expected, joint "
            f"{int(relative.argmax()) + 1} is known to {100 * relative.max():.0f} % with {payload:g} kg; take a "
            "heavier payload or record longer"
        )
