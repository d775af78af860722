from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from ident.identification.goodness_of_fit import GoodnessOfFit
from ident.paper import table
from ident.paper.methods import MethodComparison, MethodResult


def fitness(value: float) -> GoodnessOfFit:
    return GoodnessOfFit(nrmse=(value,) * 3, rms=(1.0,) * 3, r2=(0.0,) * 3)


def result(method: str, value: float) -> MethodResult:
    torque = np.zeros((1, 3))
    return MethodResult(method, {}, (torque, torque), (fitness(value), fitness(value)), 1e-9, {})


def printed(comparison: MethodComparison, capsys: pytest.CaptureFixture[str]) -> str:
    table.show(comparison, Console(width=300))
    return " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("pso", "ls", "svd", "expected"),
    [
        (0.95, 0.96, 0.7, ["The paper's order holds on validation data: pso, rls, dls, svd.", "not the search"]),
        (
            0.95,
            0.96,
            0.94,
            ["The others stand otherwise: svd, rls, dls (mean of the joints) where the paper has rls"],
        ),
        (
            0.90,
            0.96,
            0.7,
            ["PSO is not above rls on joint 1, rls on joint 2, rls on joint 3. Least squares with the same"],
        ),
        (0.90, 0.91, 0.7, ["rls on joint 3. Nor is least squares", "neither the model nor the search"]),
    ],
)
def test_the_order_is_stated_or_its_absence_explained(
    comparison: MethodComparison,
    pso: float,
    ls: float,
    svd: float,
    expected: list[str],
    capsys: pytest.CaptureFixture[str],
) -> None:
    values = {"pso": pso, "rls": 0.92, "dls": 0.8, "svd": svd, "ls": ls}
    changed = replace(comparison, results={name: result(name, value) for name, value in values.items()})
    text = printed(changed, capsys)
    assert all(sentence in text for sentence in expected)


@pytest.mark.parametrize(("own", "above", "reason"), [(0.93, 9, True), (0.79, 0, False)])
def test_places_of_the_manufacturers_model_are_counted(
    comparison: MethodComparison, own: float, above: int, reason: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    values = {"pso": 0.95, "rls": 0.92, "dls": 0.8, "svd": 0.8, "ls": 0.96}
    results = {name: result(name, value) for name, value in values.items()}
    text = printed(replace(comparison, results=results, nominal=(fitness(own), fitness(own))), capsys)
    assert f"{above} of 9 places" in text
    assert ("carries over" in text) is reason


def test_recordings_of_a_real_robot_are_not_called_simulated(
    comparison: MethodComparison, capsys: pytest.CaptureFixture[str]
) -> None:
    assert "SIMULATED" in printed(comparison, capsys)
    real = [
        replace(
            prepared,
            recording=replace(prepared.recording, run=prepared.recording.run.model_copy(update={"simulated": False})),
        )
        for prepared in comparison.prepared
    ]
    assert "SIMULATED" not in printed(replace(comparison, prepared=(real[0], real[1])), capsys)
