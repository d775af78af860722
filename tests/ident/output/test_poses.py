"""Poses of a delta robot: lengths, and colours of the residual."""

import numpy as np

from ident.output.poses import PoseSequence, pose_sequence
from ident.residuals.time_span import TorqueSeries
from recordings.rig import Geometry

GREY = "#8a949c"
GEOMETRY, TIME = Geometry(), np.arange(100) / 50


def test_limbs_have_the_lengths_of_the_geometry() -> None:
    theta = np.stack([0.3 * np.sin(TIME + phase) - 0.3 for phase in (0, 1, 2)], axis=1).astype(np.float32)
    theta[50] = np.nan
    poses = pose_sequence(GEOMETRY, TIME, theta, None)
    rods = poses.platform_joints - poses.elbows
    np.testing.assert_allclose(np.linalg.norm(poses.elbows - poses.shoulders, axis=2), GEOMETRY.L1)
    np.testing.assert_allclose(np.linalg.norm(rods, axis=2), GEOMETRY.L2, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(poses.tangents, axis=1), 1.0)
    np.testing.assert_allclose(np.sum(poses.tangents * poses.shoulders, axis=1), 0.0, atol=1e-12)
    rotation = np.array(PoseSequence.cylinder_rotation(poses.elbows[3, 0], poses.platform_joints[3, 0]))
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(rotation @ [0, GEOMETRY.L2, 0], rods[3, 0], atol=1e-9)
    assert poses.colour(0, 0) == GREY


def test_limbs_with_noise_alone_are_grey() -> None:
    residual = np.full((100, 3), 0.05) * (-1.0, 1.0, 1.0)
    residual[:, 2] = np.nan
    nothing, still = np.zeros((100, 3)), np.full((100, 3), "cruise")
    series = TorqueSeries(
        "a", False, TIME, residual, nothing, nothing, nothing, still, np.ones(100, int), np.isfinite(residual)
    )
    poses = pose_sequence(GEOMETRY, TIME, np.full((100, 3), -0.3), series, (0.04, 0.001, 0.04))
    np.testing.assert_array_equal(poses.residual, residual[: len(poses.time)])
    assert poses.colour(0, 0) == GREY == poses.colour(0, 2), "noise alone, and a row that is not scored"
    assert poses.colour(0, 1) != GREY
