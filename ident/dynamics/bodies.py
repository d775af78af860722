"""Bodies of a tree of links: pseudo-inertias that are positive semidefinite, and motors of positive inertia.

P. M. Wensing, S. Kim, J.-J. E. Slotine, "Linear matrix inequalities for physically consistent inertial parameter
identification" (2018): a link's ten parameters belong to a body exactly where its pseudo-inertia [[S, h], [h', m]] is
positive definite, with the mass m, the first moments h, and S = tr(I) / 2 - I. What is nearest is a convex problem.
"""

from functools import cache

import numpy as np

from recordings.recording import Floats

LEAST = np.diag([1e-6, 1e-6, 1e-6, 1e-4])
"""Part of each pseudo-inertia [kg m^2, kg] of links for simulators, which refuse bodies of no mass."""
_OPEN = 1e-8
"""Weight of the distance from known parameters, beside the torque: it decides only what the torque leaves open."""
_UPPER = np.triu_indices(4)
_ORDER = np.lexsort(_UPPER)
_ROWS, _COLUMNS = _UPPER[0][_ORDER], _UPPER[1][_ORDER]
"""Entries of a triangle, column by column, as the solver takes them."""
_INERTIA = (np.array([0, 0, 1, 0, 1, 2]), np.array([0, 1, 1, 2, 2, 2]))
"""Rows and columns of Ixx, Ixy, Iyy, Ixz, Iyz, Izz."""


def nearest_bodies(
    per_parameter: Floats, target: Floats, known: Floats, links: int, least: Floats | None = None
) -> Floats:
    """(k,) physical parameters, of so many `links`, then of motors, whose torque is nearest to the `target` (r,).

    per_parameter: (r, k) torque per unit of each. known: (k,) where the torque leaves it open.
    least: (4, 4) part of every link's pseudo-inertia; None: links may have no mass, as those that no torque tells.
    """
    import clarabel
    from scipy.sparse import csc_matrix

    rows, count = per_parameter.shape
    # In units in which the torque is 1, and so is the parameter that it takes to make it.
    size = float(np.linalg.norm(target)) or 1.0
    unit = size / (float(np.linalg.norm(per_parameter, axis=0).max()) or 1.0)
    weights = np.concatenate([np.full(count, _OPEN), np.ones(rows)])
    linear = np.concatenate([-_OPEN * known / unit, np.zeros(rows)])
    motors = count - 10 * links
    bodies = np.zeros((count, count))
    bodies[: 10 * links, : 10 * links] = np.kron(np.eye(links), _packing())
    bodies[10 * links :, 10 * links :] = np.eye(motors)
    fitted = np.hstack([per_parameter * (unit / size), -np.eye(rows)])
    within = np.hstack([-bodies, np.zeros((count, rows))])
    floor = np.zeros(10) if least is None else _packed(least)
    limits = np.concatenate([target / size, -np.tile(floor / unit, links), np.zeros(motors)])
    cones = [clarabel.ZeroConeT(rows), *[clarabel.PSDTriangleConeT(4)] * links]
    cones += [clarabel.NonnegativeConeT(motors)] * bool(motors)
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    quadratic, constraints = csc_matrix(np.diag(weights)), csc_matrix(np.vstack([fitted, within]))
    solver = clarabel.DefaultSolver(quadratic, linear, constraints, limits, cones, settings)
    return unit * np.array(solver.solve().x)[:count]


@cache
def _packing() -> Floats:
    """(10, 10) packed pseudo-inertia per unit of each of the `LINK_PARAMETERS`."""
    return np.array([_packed(pseudo_inertia(unit)) for unit in np.eye(10)]).T


def _packed(matrix: Floats) -> Floats:
    """(10,) triangle of a symmetric `matrix` (4, 4), of the same norm."""
    return matrix[_ROWS, _COLUMNS] * np.where(_ROWS == _COLUMNS, 1.0, np.sqrt(2))


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
