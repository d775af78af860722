"""Transforms composed by SciPy, from the messages as another library reads them."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

Poses = dict[str, np.ndarray]
"""Pose (4, 4) of each link in the root, by name."""


def poses(transforms: Iterable[Any]) -> Poses:
    """Compose messages of geometry_msgs/TransformStamped."""
    known = {each.child_frame_id: (each.header.frame_id, _matrix(each.transform)) for each in transforms}

    def pose(link: str) -> np.ndarray:
        if link not in known:
            return np.eye(4)
        parent, matrix = known[link]
        return pose(parent) @ matrix

    return {link: pose(link) for link in known}


def _matrix(transform: Any) -> np.ndarray:
    place, turn = transform.translation, transform.rotation
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
    matrix[:3, 3] = place.x, place.y, place.z
    return matrix


def rod_errors(at: Poses, length: float) -> np.ndarray:
    """(6,) distances of each rod's ends minus its length, and of its drawn end from the platform's joint [m]."""
    errors = []
    for limb in (1, 2, 3):
        rod, end = at[f"rod_{limb}"], at[f"rod_end_{limb}"][:3, 3]
        errors += [np.linalg.norm(end - rod[:3, 3]) - length, np.linalg.norm(end - (rod @ [length, 0, 0, 1])[:3])]
    return np.array(errors)
