"""Decimated time plots, and poses of the robot."""

import numpy as np

from ident.workbench import plots
from ident.workbench.pose import PoseSequence, pose_sequence
from ident.workbench.views import RecordingView, TorqueSeries
from recordings.rig import Geometry

HOUR = 1_800_000


def test_an_hour_is_decimated_without_losing_peaks() -> None:
    time, y = np.arange(HOUR) / 500, np.zeros(HOUR, np.float32)
    y[1_234_567], y[777_777] = 5.0, np.nan
    xs, ys = plots.visible_points(time, y, (0.0, 3600.0))
    assert len(xs) < 4000
    assert np.nanmax(ys) == 5.0
    assert np.isnan(ys).any(), "gaps are kept"
    xs, ys = plots.visible_points(time, y, (2469.0, 2469.2))
    assert len(xs) >= 100
    assert np.nanmax(ys) == 5.0
    assert xs[0] < 2469.0 < 2469.2 < xs[-1], "the line continues to both edges"


def test_limbs_have_the_lengths_of_the_geometry() -> None:
    geometry, time = Geometry(), np.arange(100) / 50
    theta = np.stack([0.3 * np.sin(time + phase) - 0.3 for phase in (0, 1, 2)], axis=1).astype(np.float32)
    theta[50] = np.nan
    view = RecordingView("a", {}, (), (), geometry, time, {"position": ("rad", theta)})
    poses = pose_sequence(view, geometry, None)
    arms = np.linalg.norm(poses.elbows - poses.shoulders, axis=2)
    rods = np.linalg.norm(poses.platform_joints - poses.elbows, axis=2)
    np.testing.assert_allclose(arms, geometry.L1)
    np.testing.assert_allclose(rods, geometry.L2, atol=1e-9)
    across = poses.tangents
    np.testing.assert_allclose(np.linalg.norm(across, axis=1), 1.0)
    np.testing.assert_allclose(np.sum(across * poses.shoulders, axis=1), 0.0, atol=1e-12)
    rotation = np.array(PoseSequence.cylinder_rotation(poses.elbows[3, 0], poses.platform_joints[3, 0]))
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(
        rotation @ [0, geometry.L2, 0], poses.platform_joints[3, 0] - poses.elbows[3, 0], atol=1e-9
    )
    assert poses.colour(0, 0) == "#8a949c"


def test_limbs_with_noise_alone_are_grey() -> None:
    geometry, time = Geometry(), np.arange(100) / 50
    view = RecordingView("a", {}, (), (), geometry, time, {"position": ("rad", np.full((100, 3), -0.3, np.float32))})
    residual = np.full((100, 3), 0.05) * (-1.0, 1.0, 1.0)
    residual[:, 2] = np.nan
    nothing, still = np.zeros((100, 3)), np.full((100, 3), "cruise")
    series = TorqueSeries(
        "a", False, time, residual, nothing, nothing, nothing, still, np.ones(100, int), np.isfinite(residual)
    )
    poses = pose_sequence(view, geometry, series, (0.04, 0.001, 0.04))
    np.testing.assert_array_equal(poses.residual, residual[: len(poses.time)])
    assert poses.colour(0, 0) == "#8a949c" == poses.colour(0, 2), "noise alone, and a row that is not scored"
    assert poses.colour(0, 1) != "#8a949c"
