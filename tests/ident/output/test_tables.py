"""Cells of the tables are the numbers of the results, whatever shows them."""

from dataclasses import replace

import pytest

from ident.dynamics.effects.base import INFINITE_TIME
from ident.identification.model_file import ModelFile
from ident.output.tables import ResultTable, parameters, recordings, residuals
from ident.residuals.analysis import ResidualAnalysis
from recordings.recording import Recording
from tests.ident.output.conftest import HOSTILE


def number(table: ResultTable, row: int, column: str) -> float:
    """The number with which a cell begins."""
    return float(table.rows[row][list(table.head).index(column)].split()[0].rstrip("%"))


def test_residuals(analysis: ResidualAnalysis) -> None:
    for row, joint in enumerate(analysis.joints):
        table = residuals.summary({"a": analysis})
        assert number(table, row, "joint") == joint.summary.number
        assert number(table, row, "RMS") == pytest.approx(joint.summary.rms, rel=0.01)
        assert number(table, row, "of RMS torque") == pytest.approx(100 * joint.summary.share, abs=0.06)
        assert number(table, row, "RMS of all rows") == pytest.approx(joint.summary.rms_all, rel=0.01)
        shares = [
            float(cell.partition("(")[2].split()[0]) for cell in residuals.phases(analysis).rows[row][1:] if cell
        ]
        assert sum(shares) == pytest.approx(100, abs=3)
        curve = replace(joint.curves[0], explained=0.42)
        alone = replace(analysis, joints=(replace(joint, curves=(curve,)),))
        assert [*residuals.dependence(alone).rows] == [(str(row + 1), "42 %")]
    assert residuals.summary({"a": analysis, "b": analysis}).rows[-1][:2] == ("b", "3")


def test_worst_intervals_name_their_recording_if_there_are_several(analysis: ResidualAnalysis) -> None:
    table, window = residuals.windows(analysis), analysis.windows[0]
    assert (number(table, 0, "joint"), number(table, 0, "from")) == (window.joint, round(window.start, 2))
    assert "in" not in table.head
    several = residuals.windows(replace(analysis, predictions=analysis.predictions * 2))
    assert several.rows[0][-1] == HOSTILE


def test_parameters_and_agreement(model: ModelFile) -> None:
    first = model.parameters[0]
    for table in (parameters.side_by_side({"a": model}), parameters.fitted(model)):
        assert table.rows[0][0] == first.name
        assert number(table, 0, "value") == pytest.approx(first.value, rel=1e-3)
        assert number(table, 0, "± 95 %") == pytest.approx((first.shape_ci95[1] - first.shape_ci95[0]) / 2, rel=0.1)
    assert len(parameters.side_by_side({"a": model, "b": model}).head) == 8
    instant = first.model_copy(update={"name": "payload_change.t_e", "unit": "s", "value": INFINITE_TIME})
    with_instant = parameters.fitted(model.model_copy(update={"searched": (instant,)}))
    assert with_instant.rows[-1][:2] == ("payload_change.t_e", "never")
    agreement = parameters.agreement(model)
    assert number(agreement, 1, "Eq. (41)") == pytest.approx(model.train.fitted.nrmse[1], abs=1e-4)
    assert agreement.rows[0][4].split(" | ")[0] == f"{model.train.fitted.r2[0]:.4f}"
    assert parameters.correlations(model, model.assessment).rows[0][1] == "100"
    assert number(parameters.details(model, model.assessment), 0, "std. error") == pytest.approx(first.std, rel=0.1)


def test_facts_of_recordings(late: Recording) -> None:
    facts = recordings.facts(late)
    assert facts["Lost samples"] == "joint 2: 3"
    assert facts["Lateness"].endswith("worst 2.00 ms")
    assert "L2 0.8 m (assumed)" in facts["Geometry"]
    assert "relative" in facts["Torque gain"]
    assert [*recordings.warnings(late)] == ["3 samples were lost; they are excluded, not interpolated."]
    table = recordings.side_by_side([late, late], {"Role": ["held out", "not used"]})
    assert table.rows[0] == ("Role", "held out", "not used")
    assert len(table.rows) == len(facts) + 1
