"""Bodies with given base parameters: links whose pseudo-inertia is positive definite, nearest to them.

Every link's matrix is L L' with a small addition, and every motor's inertia a square, so that any L is a body. What
the base parameters leave open stays near the URDF's values.

P. M. Wensing, S. Kim, J.-J. E. Slotine, "Linear matrix inequalities for physically consistent inertial parameter
identification" (2018): a link's ten parameters belong to a body exactly where its pseudo-inertia [[S, h], [h', m]] is
positive definite, with the mass m, the first moments h, and S = tr(I) / 2 - I.
"""

import numpy as np

from ident.dynamics.mechanisms.urdf import Urdf
from ident.dynamics.rigid_chain import LINK_PARAMETERS
from recordings.recording import Floats

_LEAST = np.diag([1e-6, 1e-6, 1e-6, 1e-4])
"""Addition to each pseudo-inertia [kg m^2, kg], for simulators, which refuse bodies of no mass."""
_NEAR = (1e-2, 1e-5)
"""Weights of the distance [kg, kg m, kg m^2] from the beginning, beside the errors of the base parameters: the first
leads the search, the second leaves them free."""
_ENTRIES = np.tril_indices(4)
_INERTIA = (np.array([0, 0, 1, 0, 1, 2]), np.array([0, 1, 1, 2, 2, 2]))
"""Rows and columns of Ixx, Ixy, Iyy, Ixz, Iyz, Izz."""


def nearest_bodies(mechanism: Urdf, base: Floats, root: Floats, *, massless: bool = False) -> Floats:
    """(k,) physical parameters: of the links, and of the motors where they are parameters.

    root: (r, b) whose product with an error of the `base` parameters (b,) has the square that is minimised.
    massless: links may have no mass, as those that no torque tells.
    """
    from scipy.optimize import least_squares

    per_parameter = root @ mechanism.base.combination
    wanted = mechanism.physical_parameters(base)
    least = np.zeros_like(_LEAST) if massless else _LEAST
    theta = _beginning(mechanism, wanted)
    reference = _physical(mechanism, theta, least)[0]
    for weight in _NEAR:

        def residual(x: Floats, weight: float = weight) -> Floats:
            parameters = _physical(mechanism, x, least)[0]
            return np.concatenate([per_parameter @ (parameters - wanted), weight * (parameters - reference)])

        def derivative(x: Floats, weight: float = weight) -> Floats:
            slopes = _physical(mechanism, x, least)[1]
            return np.concatenate([per_parameter @ slopes, weight * slopes])

        theta = least_squares(residual, theta, derivative, x_scale="jac", max_nfev=500).x
    return _physical(mechanism, theta, least)[0]


def _beginning(mechanism: Urdf, parameters: Floats) -> Floats:
    """Entries of L and roots of the motors' inertias, near the `parameters`, which no body may have."""
    count = mechanism.links.nominal_parameters.size
    values, vectors = np.linalg.eigh(pseudo_inertia(parameters[:count].reshape(-1, len(LINK_PARAMETERS))))
    kept = np.maximum(values, 1e-3 * max(1.0, float(values.max())))
    factors = np.linalg.cholesky(np.einsum("nij,nj,nkj->nik", vectors, kept, vectors))
    entries = factors[:, _ENTRIES[0], _ENTRIES[1]].ravel()
    return np.concatenate([entries, np.sqrt(np.maximum(parameters[count:], 1e-3))])


def _physical(mechanism: Urdf, theta: Floats, least: Floats) -> tuple[Floats, Floats]:
    """Physical parameters (k,) of `theta` (k,), and their derivatives (k, k)."""
    count = mechanism.links.nominal_parameters.size
    factors = np.zeros((count // 10, 4, 4))
    factors[:, _ENTRIES[0], _ENTRIES[1]] = theta[:count].reshape(-1, 10)
    motors = theta[count:]
    slopes = np.zeros((len(theta), len(theta)))
    units = np.zeros((10, 4, 4))
    units[np.arange(10), _ENTRIES[0], _ENTRIES[1]] = 1.0
    for link, L in enumerate(factors):
        turned = units @ L.T
        here = slice(10 * link, 10 * link + 10)
        slopes[here, here] = link_parameters(turned + turned.swapaxes(1, 2)).T
    slopes[count:, count:] = np.diag(2 * motors)
    links = link_parameters(factors @ factors.swapaxes(1, 2) + least)
    return np.concatenate([links.ravel(), motors**2]), slopes


def pseudo_inertia(parameters: Floats) -> Floats:
    """Return the matrices (..., 4, 4) of links with the parameters (..., 10), `LINK_PARAMETERS`."""
    result = np.zeros((*parameters.shape[:-1], 4, 4))
    inertia = np.zeros((*parameters.shape[:-1], 3, 3))
    inertia[..., _INERTIA[0], _INERTIA[1]] = inertia[..., _INERTIA[1], _INERTIA[0]] = parameters[..., 4:]
    trace = np.trace(inertia, axis1=-2, axis2=-1)[..., None, None]
    result[..., :3, :3] = trace / 2 * np.eye(3) - inertia
    result[..., :3, 3] = result[..., 3, :3] = parameters[..., 1:4]
    result[..., 3, 3] = parameters[..., 0]
    return result


def link_parameters(pseudo: Floats) -> Floats:
    """Return the parameters (..., 10) of links with the pseudo-inertia (..., 4, 4)."""
    S = pseudo[..., :3, :3]
    inertia = np.trace(S, axis1=-2, axis2=-1)[..., None, None] * np.eye(3) - S
    return np.concatenate([pseudo[..., 3:, 3], pseudo[..., :3, 3], inertia[..., _INERTIA[0], _INERTIA[1]]], axis=-1)
