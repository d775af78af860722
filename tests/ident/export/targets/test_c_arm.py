"""The C code of an arm gives the torque that Python gives."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ident.dynamics.effects.library import library
from ident.export import targets
from ident.export.c_source import code_of
from ident.export.targets import c
from tests.ident.export.arms import arm_model, arm_path
from tests.ident.export.targets.compilers import Stepped, compiled

pytest.importorskip("pinocchio")

DT = 4e-3
EFFECTS = [name for name, effect in library().items() if "urdf" in effect.mechanisms and code_of(effect, links=True)]
PAYLOAD = {"mass": 1.0, "com": (0.1, 0.0, 0.2)}


@pytest.mark.parametrize(
    ("names", "keys"),
    [
        (EFFECTS, {"payload": PAYLOAD, "couplings": ({"of": 3, "by": 1, "ratio": 0.3},)}),
        ([], {"gravity": (0.0, 5.0, -8.0), "couplings": ({"of": 3, "by": 2, "ratio": 0.5},)}),
        ([], {"motor_inertia": False, "joints": ("push", "turn", "lift")}),
    ],
)
def test_c_equals_python(names: list[str], keys: dict[str, Any], tmp_path: Path) -> None:
    model = arm_model(names, **keys)
    c.write(targets.ExportRequest(model, arm_path(), tmp_path, targets.settings("c", {}), "0"))
    q, qd, qdd = np.random.default_rng(0).uniform(-1, 1, (3, 2000, 3)) * np.array([[[2.0]], [[4.0]], [[30.0]]])
    expected = model.torque(q, qd, qdd, DT, DT * np.arange(len(q)), np.full_like(q, 25.0))
    difference = Stepped(compiled(tmp_path)).torque(q, qd, qdd, DT) - expected
    assert np.abs(difference).max() < 1e-12 * np.abs(expected).max()
