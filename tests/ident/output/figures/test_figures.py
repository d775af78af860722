"""Figures show what the results hold, with units on their axes, and no name from a file as markup."""

from dataclasses import replace

import numpy as np
import plotly.graph_objects as go
import pytest

from ident.identification.model_file import ModelFile
from ident.output.figures import parameters, quality, residuals, spectrum, torque
from ident.residuals.analysis import ResidualAnalysis
from recordings.recording import Recording


def axis_titles(figure: go.Figure, letter: str) -> list[str]:
    return [axis.title.text for axis in getattr(figure, f"select_{letter}axes")() if axis.title.text]


@pytest.fixture(params=[1, 2])
def analyses(request: pytest.FixtureRequest, analysis: ResidualAnalysis) -> dict[str, ResidualAnalysis]:
    names = ["a<b>.json", "other.json"][: request.param]
    return dict.fromkeys(names, analysis)


def test_no_figure_shows_a_name_as_markup(analyses: dict[str, ResidualAnalysis], analysis: ResidualAnalysis) -> None:
    figures = [
        torque.over_time(analyses, 0),
        torque.worst_windows(replace(analysis, predictions=analysis.predictions * 2)),
        residuals.phases(analyses),
        residuals.curves(analyses),
        spectrum.densities(analyses),
        quality.mean_square_shares(analyses),
    ]
    for figure in figures:
        text = figure.to_json()
        assert "<script" not in text
        assert "a<b>" not in text


def test_torque_and_residual_share_one_time_axis(
    analyses: dict[str, ResidualAnalysis], analysis: ResidualAnalysis
) -> None:
    figure = torque.over_time(analyses, 0)
    assert len(list(figure.select_yaxes())) == 6
    assert {axis.matches for axis in figure.select_xaxes()} <= {None, "x6"}
    assert "time [s]" in axis_titles(figure, "x")
    assert all("[N m]" in title for title in axis_titles(figure, "y"))
    residual_traces = [trace for trace in figure.data if trace.name.endswith("residual")]
    assert len(residual_traces) == 3 * len(analyses)
    rms = np.sqrt(np.nanmean(np.asarray(residual_traces[0].y, np.float64) ** 2))
    assert rms == pytest.approx(analysis.joints[0].summary.rms_all, rel=1e-3)


def test_curves_name_their_quantity_and_its_unit(analyses: dict[str, ResidualAnalysis]) -> None:
    figure = residuals.curves(analyses)
    labels = axis_titles(figure, "x")
    assert labels == ["velocity [rad/s]", "position [rad]", "computed load [N m]", "time [s]", "cycle"]


def test_motion_and_timing_show_gap_and_lateness(late: Recording) -> None:
    assert quality.has_timing(late)
    figure = quality.timing(late)
    assert np.nanmax(np.asarray(figure.data[0].y, float)) == pytest.approx(2.0)
    assert [len(trace.x) for trace in figure.data[1:]] == [0, 3, 0]
    assert len(quality.motion(late).data) == 9
    assert not quality.has_timing(replace(late, position=late.command, lateness=np.zeros_like(late.lateness)))


def test_parameters_show_half_width_in_percent(model: ModelFile) -> None:
    figure = parameters.precision({"a": model})
    shown = {name: x for trace in figure.data for name, x in zip(trace.y, trace.x, strict=True)}
    first = model.parameters[0]
    assert shown[first.name] == pytest.approx(50 * (first.ci95[1] - first.ci95[0]) / first.value)
    heat = parameters.correlation(model).data[0]
    assert np.asarray(heat.z).shape == (11, 11)
    assert np.asarray(heat.z)[0, 0] == pytest.approx(1)
