import numpy as np
import pytest

from ident.design.quality import motion_quality
from ident.dynamics import mechanisms
from ident.dynamics.motion import Motion
from ident.filters import mean_sign
from recordings.rig import Axis, Limits, Rig
from trajectories import Trajectory
from trajectories.fourier import FourierSeries
from trajectories.trajectory import assemble

RIG = Rig(name="bench", mechanism="axes", axes=(Axis(),), limits=Limits(joint_min=-2.0, joint_max=2.0))


def wave(*sines: float) -> Trajectory:
    series = FourierSeries(
        kind="fourier", space="joint", period=2.0, centre=(0.0,), cosine=((0.0,) * len(sines),), sine=(sines,)
    )
    return assemble(series.motion("wave"), RIG)


def test_standard_errors_agree_with_many_fits() -> None:
    trajectory, rng = wave(0.5, 0.3), np.random.default_rng(0)
    quality = motion_quality(trajectory, RIG, mechanisms.create(RIG), noise=0.2, bandwidth=np.inf)
    repeated = trajectory.repeat >= 0
    direction = mean_sign(trajectory.joint_velocity)
    motion = Motion(
        *(x[repeated] for x in (trajectory.joint_position, trajectory.joint_velocity)),
        *(x[repeated] for x in (trajectory.joint_acceleration, direction)),
    )
    rows = mechanisms.create(RIG).regressor(motion)[:, 0]
    fits = np.linalg.lstsq(rows, rng.normal(0, 0.2, (len(rows), 400)), rcond=None)[0]
    np.testing.assert_allclose(quality.std, fits.std(axis=1), rtol=0.15)


def test_band_limited_noise_has_fewer_independent_samples() -> None:
    narrow, wide = (motion_quality(wave(0.5, 0.3), RIG, mechanisms.create(RIG), 0.1, hz) for hz in (25.0, 250.0))
    np.testing.assert_allclose(narrow.std, wide.std * np.sqrt(10))


def test_parameters_that_are_not_excited_have_infinite_standard_errors() -> None:
    rig = RIG.model_copy(update={"axes": (Axis(gravity=True),)})
    quality = motion_quality(wave(1e-7), rig, mechanisms.create(rig), 0.1, 30.0)
    assert np.isinf(quality.std).any()
    assert quality.condition > 1e3


def test_usage_is_relative_to_the_limits() -> None:
    quality = motion_quality(wave(1.0), RIG, mechanisms.create(RIG), 0.1, 30.0)
    assert quality.usage["joint_min or joint_max"] == pytest.approx(0.5, rel=1e-3)
    assert quality.usage["speed"] == pytest.approx(np.pi / RIG.limits.speed, rel=1e-3)
