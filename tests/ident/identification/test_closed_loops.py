"""A closed loop, or joints that mimic others, from arrays to a model: fit, evaluation, inverse."""

from pathlib import Path

import numpy as np
import pytest

import ident
from ident.dynamics import mechanisms
from ident.dynamics.motion import Motion
from tests.ident.dynamics.loops import four_bar_keys, mimicking, rig

pytest.importorskip("pinocchio")

RIG = """name = "linkage"
mechanism = "urdf"
urdf = "linkage.urdf"
joints = ["drive"]
"""
LOOP = 'loops = [{ a = "coupler", b = "rocker", point_a = [0.5, 0, 0], point_b = [0, 0, 0.4] }]'
PARALLELOGRAM = mimicking(four_bar_keys()["urdf"], elbow=("drive", -1.0, 0.0), pivot=("drive", 1.0, 0.0))
VISCOUS, COULOMB = 0.4, 0.6


@pytest.mark.parametrize(
    ("rocker", "urdf", "keys", "near"),
    [(0.4, four_bar_keys()["urdf"], LOOP, 0.2), (0.3, PARALLELOGRAM, "", 0.005)],
    ids=["loop", "mimic"],
)
def test_fitted_linkage_has_the_torque_of_the_true_one(
    rocker: float, urdf: str, keys: str, near: float, tmp_path: Path
) -> None:
    (tmp_path / "linkage.urdf").write_text(urdf, encoding="utf-8")
    (tmp_path / "rig.toml").write_text(RIG + keys, encoding="utf-8")
    t = np.arange(0, 10, 0.02)[:, None]
    rates = 2 * np.pi * np.array([0.3, 0.7, 1.1])
    q, v, a = (
        (size * 0.3 * shape(rates * t)).sum(axis=1, keepdims=True)
        for size, shape in ((np.ones(3), np.sin), (rates, np.cos), (-(rates**2), np.sin))
    )
    truth = mechanisms.create(rig(four_bar_keys(rocker))).nominal_torque(Motion(q, v, a, np.sign(v)))
    assert truth is not None
    truth = truth + VISCOUS * v + COULOMB * np.sign(v)
    recording = ident.Recording.from_arrays(t[:, 0], q, effort=truth, rig=tmp_path / "rig.toml")
    ident.fit(recording, method="wls").save(tmp_path / "model.json")
    model = ident.load_model(tmp_path / "model.json")
    inside = slice(50, -50)
    error = model.torque(q, v, a)[inside] - truth[inside]
    assert np.sqrt(np.mean(error**2)) < 0.01 * truth.std()
    assert model.parameters["c_c1"].value == pytest.approx(COULOMB, rel=0.05)
    torque = model.torque(q[:20], v[:20], a[:20])
    np.testing.assert_allclose(model.acceleration(q[:20], v[:20], torque), a[:20], atol=1e-6)
    assert model.file.robot == recording.rig.chain
    mechanism = mechanisms.create(recording.rig)
    known = mechanism.base.combination @ mechanism.known_parameters  # type: ignore[union-attr]
    np.testing.assert_allclose([*map(float, model.parameters.values())][: len(known)], known, atol=near)
