"""Swarms on a short recording: figures of a study, and what is said of them."""

import csv
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from ident.paper import study, study_views
from ident.paper.methods import MethodComparison
from ident.paper.study import SwarmGroup, SwarmRun, SwarmStudy

BRIEF = {"pso": {"iterations": 60}, "pso_classic": {"iterations": 60}}


@pytest.fixture(scope="module")
def studied(comparison: MethodComparison) -> SwarmStudy:
    return study.study_swarms(comparison, [5, 6], [20, 60], BRIEF, lambda *_: None)


def group(method: str, particles: int, *excess: float) -> SwarmGroup:
    """Swarms that start at an excess of 1 and end at these."""
    runs = [
        SwarmRun(seed, np.array([1.0, end]), np.array([1.0, 0.5]), np.array([2.0 + seed, -1.0]), (0.9 + end, 0.9))
        for seed, end in enumerate(excess)
    ]
    return SwarmGroup(method, particles, None, tuple(runs))


def test_a_group_reports_how_far_and_how_fast_its_seeds_come() -> None:
    some = group("pso", 50, 1e-7, 1e-4, 0.5)
    assert some.reached(1e-3) == [1, 1]
    assert some.reached(1e-6) == [1]
    assert some.reached(2.0) == [0, 0, 0]
    assert some.nrmse_range == pytest.approx(0.5, rel=1e-6)
    assert some.parameter_range == pytest.approx(2 / 3)


@pytest.mark.parametrize(
    ("cyclic", "classical", "expected"),
    [
        (1e-9, 1e-4, ["ends farther from the minimum", "50 particles are enough"]),
        (1e-4, 1e-9, ["ends no farther from the minimum", "no size is enough"]),
    ],
)
def test_sentences_follow_the_figures(cyclic: float, classical: float, expected: list[str]) -> None:
    text = " ".join(
        study_views.sentences(
            SwarmStudy((group("pso", 50, cyclic), group("pso_classic", 50, classical)), ("a", "b"), "")
        )
    )
    assert all(words in text for words in expected)


def test_table_picture_and_data_show_every_group(
    studied: SwarmStudy, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    study_views.show(studied, Console(width=200))
    assert "swarms from 2 seeds" in capsys.readouterr().out
    study_views.draw(studied, tmp_path / "study.png")
    assert (tmp_path / "study.png").stat().st_size > 10_000
    study_views.write(studied, tmp_path)
    with (tmp_path / "study.csv").open() as stream:
        runs = list(csv.DictReader(stream))
    assert len(runs) == 8
    assert float(runs[0]["m_p"]) == pytest.approx(studied.groups[0].runs[0].parameters[0])
    assert runs[2]["neighbours"] == ""
    with (tmp_path / "convergence.csv").open() as stream:
        steps = list(csv.DictReader(stream))
    assert len(steps) == 4 * 61
    assert (steps[0]["method"], steps[0]["particles"], runs[0]["neighbours"]) == ("pso", "20", "4")
    medians = np.array([float(row["excess_median"]) for row in steps]).reshape(4, 61)
    assert (np.diff(medians) <= 0).all()
    assert all(
        float(row["excess_lowest"]) <= float(row["excess_median"]) <= float(row["excess_highest"]) for row in steps
    )
