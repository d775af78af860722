"""The document about what an export carries and loses."""

import json
from pathlib import Path

import numpy as np
import pytest

from ident.dynamics.inverse_dynamics import InverseDynamics
from ident.export import losses, paths
from recordings.rig import simulated_rig
from tests.ident.export.models import model_with


def test_torque_of_lost_effects_is_told_and_no_voltage_computed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("the losses are torques")

    monkeypatch.setattr(InverseDynamics, "reported", refuse)
    model = model_with(["joint_spring", "quadratic_friction", "back_emf"])
    carried = losses.sorted_by(model, {"quadratic_friction": "no room", "back_emf": "no room"})
    assert carried == losses.Carried(("joint_spring",), {"quadratic_friction": "no room"}, ("back_emf",))

    path, out = paths.from_trajectory("fig5b", simulated_rig(), 1, 100.0), tmp_path / "carried.json"
    losses.write(model, carried, path, out, "c")
    document = json.loads(out.read_text())
    motion = path.motion
    terms = model.terms(motion.position, motion.velocity, motion.acceleration)
    lost = np.sqrt((terms["quadratic_friction"] ** 2).mean(axis=0))
    np.testing.assert_allclose(document["torque_lost_rms"], lost)
    assert [entry["effect"] for entry in document["not_carried"]] == ["quadratic_friction"]
    assert (document["carried"], document["voltage_only"]) == (["joint_spring"], ["back_emf"])
