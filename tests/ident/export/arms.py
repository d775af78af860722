"""Models of an arm from a URDF, with effects of any value, for exports."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ident.dynamics import mechanisms
from ident.dynamics.motion import Motion
from ident.export.paths import GivenPath
from ident.identification.model import Model
from recordings.rig import Rig
from tests.ident.export.models import model_of
from tests.ident.identification.test_urdf_robot import COULOMB, OFFSET, URDF, VISCOUS, motion


def arm_path() -> GivenPath:
    """A motion of the arm."""
    time, q, qd, qdd = motion(1, seconds=6.0)
    return GivenPath("sines", float(1 / time[1]), time, Motion(q, qd, qdd, np.sign(qd)))


def arm_model(names: Sequence[str] = (), noise: float = 0.0, **keys: Any) -> Model:
    """The arm of the URDF, its base parameters known but for relative `noise`, with the effects `names`."""
    known = {"urdf": URDF, "joints": ("turn", "lift", "push"), **keys}
    rig = Rig(name="arm", mechanism="urdf", **known)
    mechanism = mechanisms.create(rig)
    base = mechanism.base  # type: ignore[attr-defined]
    motors = [0.3, 0.2, 0.9] if rig.motor_inertia else []
    truth = base.combination @ [*mechanism.links.nominal_parameters, *motors]  # type: ignore[attr-defined]
    truth = truth + noise * np.random.default_rng(0).standard_normal(len(truth)) * np.abs(truth).max()
    return model_of(rig, np.concatenate([truth, VISCOUS, COULOMB, OFFSET]), names)
