"""Figures over time: few points that look like many; where the robot's parts are."""

import numpy as np

from ident.workbench import plots
from ident.workbench.pose import PoseSequence, pose_sequence
from ident.workbench.views import RecordingView
from recordings.rig import Geometry

HOUR = 1_800_000


def test_an_hour_is_shown_in_few_points_and_no_peak_is_lost() -> None:
    time, y = np.arange(HOUR) / 500, np.zeros(HOUR, np.float32)
    y[1_234_567], y[777_777] = 5.0, np.nan
    xs, ys = plots.visible_points(time, y, (0.0, 3600.0))
    assert len(xs) < 4000
    assert np.nanmax(ys) == 5.0
    assert np.isnan(ys).any(), "a gap stays a gap"
    xs, ys = plots.visible_points(time, y, (2469.0, 2469.2))
    assert len(xs) >= 100
    assert np.nanmax(ys) == 5.0
    assert xs[0] < 2469.0 < 2469.2 < xs[-1], "the line goes on to both edges"


def test_limbs_are_as_long_as_the_geometry_says() -> None:
    geometry, time = Geometry(), np.arange(100) / 50
    theta = np.stack([0.3 * np.sin(time + phase) - 0.3 for phase in (0, 1, 2)], axis=1).astype(np.float32)
    theta[50] = np.nan
    view = RecordingView("a", (), (), (), geometry, ("rad",) * 3, time, {"position": ("rad", theta)})
    found = pose_sequence(view, None)
    arms = np.linalg.norm(found.elbows - found.shoulders, axis=2)
    rods = np.linalg.norm(found.platform_joints - found.elbows, axis=2)
    np.testing.assert_allclose(arms, geometry.L1)
    np.testing.assert_allclose(rods, geometry.L2, atol=1e-9)
    turned = np.array(PoseSequence.cylinder_rotation(found.elbows[3, 0], found.platform_joints[3, 0]))
    np.testing.assert_allclose(turned @ turned.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(turned @ [0, geometry.L2, 0], found.platform_joints[3, 0] - found.elbows[3, 0], atol=1e-9)
    assert found.colour(0, 0) == "#8a949c"
