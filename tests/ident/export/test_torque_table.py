"""The table of torques: its columns, and the RMS of each cause."""

import numpy as np
import pytest

import ident
from ident.export import paths
from ident.export.torque_table import TorqueSummary, tables
from recordings.rig import simulated_rig
from tests.ident.kept_models import MODELS


def test_columns_and_shares_are_those_of_the_model() -> None:
    model = ident.load_model(MODELS / "stribeck.model.json")
    path, summary = paths.from_trajectory("fig5b", simulated_rig(), 1, 100.0), TorqueSummary()
    (table,) = tables(model, path, summary)
    motion = path.motion
    given = (motion.position, motion.velocity, motion.acceleration)
    torque, voltage, terms = model.torque(*given), model.voltage(*given), model.terms(*given)
    assert list(table)[:4] == ["time", "position_1", "position_2", "position_3"]
    np.testing.assert_allclose(np.column_stack([table[f"torque_{j}"] for j in (1, 2, 3)]), torque, rtol=1e-12)
    np.testing.assert_allclose(np.column_stack([table[f"voltage_{j}"] for j in (1, 2, 3)]), voltage, rtol=1e-12)
    parts = [table[f"{name}_2"] for name in terms]
    np.testing.assert_allclose(np.sum(parts, axis=0), table["torque_2"], atol=1e-12 * np.abs(torque).max())
    np.testing.assert_allclose(summary.torque_rms, np.sqrt((torque**2).mean(axis=0)))
    for name, values in terms.items():
        np.testing.assert_allclose(summary.rms[name], np.sqrt((values**2).mean(axis=0)))
        np.testing.assert_allclose(summary.share[name], summary.rms[name] / summary.torque_rms)


def test_rows_that_are_not_known_do_not_count() -> None:
    summary = TorqueSummary()
    summary.add(np.array([[3.0], [np.nan]]), {"gravity": np.array([[3.0], [1.0]])})
    assert summary.rms["gravity"] == pytest.approx(3.0)
