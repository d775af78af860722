"""Sections of the report: where the torque goes, frequency responses, how to reproduce it."""

from pathlib import Path

import numpy as np
import pytest

from ident.output.report.blocks import Text, plots
from ident.output.report.contents import ReportContents, ReportRequest, gather
from ident.output.report.sections import causes, response
from ident.output.report.sections.reproduce import file_names
from ident.output.tables import ResultTable
from tests.ident.estimation.test_axis_model import made_up
from tests.ident.kept_models import MODELS


@pytest.fixture(scope="module")
def contents() -> ReportContents:
    request = ReportRequest((MODELS / "lad.model.json",), (MODELS / "fig5a.mcap",), (), (), diagnose=False)
    return gather(request, lambda text: None)


def test_causes_stand_in_plot_and_table_and_the_coupling_in_a_sentence(contents: ReportContents) -> None:
    section = causes.section(contents)
    text, plot, table = section.blocks
    names = ["inertia", "inertia_coupling", "coriolis", "gravity", "viscous", "coulomb"]
    assert [row[0] for row in table.rows] == [*names, "torque"]
    coupling = max(float(cell.split(" ")[0]) for cell in table.rows[1][1:])
    assert f"would lose up to {coupling:.3g} N m RMS" in text.lines[1]
    bars = [trace for trace in plot.figure.data if trace.type == "bar"]
    assert len(bars) == 3
    for joint, bar in enumerate(bars, start=1):
        shown = [float(row[joint].split(" ")[0]) for row in table.rows[:-1]]
        np.testing.assert_allclose(bar.x, shown, rtol=0.02)


def test_every_response_has_its_sentence_its_plot_and_its_figures() -> None:
    section = response.section((made_up(0.003, None), made_up(0.0, 124.2)))
    texts = [block.lines[0] for block in section.blocks if isinstance(block, Text)]
    assert texts == [
        "Joint 2: It is a delay of 3 ms, not elasticity: no resonance up to 99.8 Hz.",
        "Joint 2: It is elasticity (resonance at 124 Hz), not a delay.",
    ]
    assert [plot.id for plot in plots(section.blocks)] == ["response-1", "response-2"]
    rigid, elastic = [dict(block.rows) for block in section.blocks if isinstance(block, ResultTable)]
    assert (rigid["delay"], rigid["resonance"]) == ("3.00 ms", "none")
    assert (elastic["antiresonance"], elastic["resonance"]) == ("62.1 Hz", "124 Hz")


def test_files_with_equal_names_are_listed_with_their_folders() -> None:
    def listed(*recordings: str) -> list[str]:
        files = tuple(map(Path, recordings))
        return [*file_names(ReportRequest((Path("a/m.json"),), files, (), (), diagnose=True)).values()]

    assert listed("a/fig5a.mcap", "b/fig5b.mcap") == ["m.json", "fig5a.mcap", "fig5b.mcap"]
    ambiguous = ["a/fig5a.mcap", "b/fig5a.mcap", "b/c/fig5b.mcap"]
    assert listed(*ambiguous) == ["a/m.json", *ambiguous]
