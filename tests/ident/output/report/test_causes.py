"""The section about where the torque goes."""

import numpy as np
import pytest

from ident.output.report.blocks import Plot, Text
from ident.output.report.contents import ReportContents, ReportRequest, gather
from ident.output.report.sections import causes
from ident.output.tables import ResultTable
from tests.ident.kept_models import MODELS


@pytest.fixture(scope="module")
def contents() -> ReportContents:
    request = ReportRequest((MODELS / "lad.model.json",), (MODELS / "fig5a.mcap",), (), (), diagnose=False)
    return gather(request, lambda text: None)


def test_causes_stand_in_plot_and_table_and_the_coupling_in_a_sentence(contents: ReportContents) -> None:
    section = causes.section(contents)
    text, plot, table = section.blocks
    assert isinstance(text, Text)
    assert isinstance(plot, Plot)
    assert isinstance(table, ResultTable)
    names = ["inertia", "inertia_coupling", "coriolis", "gravity", "viscous", "coulomb"]
    assert [row[0] for row in table.rows] == [*names, "torque"]
    coupling = max(float(cell.split(" ")[0]) for cell in table.rows[1][1:])
    assert f"would lose up to {coupling:.3g} N m RMS" in text.lines[1]
    bars = [trace for trace in plot.figure.data if trace.type == "bar"]
    assert len(bars) == 3
    for joint, bar in enumerate(bars, start=1):
        shown = [float(row[joint].split(" ")[0]) for row in table.rows[:-1]]
        np.testing.assert_allclose(bar.x, shown, rtol=0.02)


def test_independent_axes_have_no_coupling() -> None:
    from ident.export.torque_table import TorqueSummary

    summary = TorqueSummary()
    summary.add(np.ones((5, 2)), {"inertia": np.ones((5, 2)), "inertia_coupling": np.zeros((5, 2))})
    assert "move independently" in causes._sentences(summary)[0]
