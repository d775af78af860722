"""Section of the report with the frequency response."""

from ident.output.report import blocks
from ident.output.report.sections import response
from ident.output.tables import ResultTable
from tests.ident.estimation.test_axis_response import made_up


def test_every_response_has_its_sentence_its_plot_and_its_figures() -> None:
    section = response.section((made_up(0.003, None), made_up(0.0, 124.2)))
    texts = [block.lines[0] for block in section.blocks if isinstance(block, blocks.Text)]
    assert texts == [
        "Joint 2: It is a delay of 3 ms, not elasticity: no resonance up to 99.8 Hz.",
        "Joint 2: It is elasticity (resonance at 124 Hz), not a delay.",
    ]
    assert [plot.id for plot in blocks.plots(section.blocks)] == ["response-1", "response-2"]
    rigid, elastic = [dict(block.rows) for block in section.blocks if isinstance(block, ResultTable)]
    assert (rigid["delay"], rigid["resonance"]) == ("3.00 ms", "none")
    assert (elastic["antiresonance"], elastic["resonance"]) == ("62.1 Hz", "124 Hz")
