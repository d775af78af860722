import csv
from pathlib import Path

import numpy as np
import pytest

from ident.paper import figures
from ident.paper.methods import MethodComparison
from recordings.recording import Floats


def table(path: Path) -> dict[str, Floats]:
    with path.open(encoding="utf-8") as stream:
        header, *rows = csv.reader(stream)
    values = np.array([[float(cell) if cell else np.nan for cell in row] for row in rows])
    return dict(zip(header, values.T, strict=True))


@pytest.fixture(scope="module")
def folder(comparison: MethodComparison, tmp_path_factory: pytest.TempPathFactory) -> Path:
    drawn = tmp_path_factory.mktemp("figures")
    figures.draw(comparison, drawn)
    return drawn


def test_figure_3_shows_the_recorded_voltage_and_those_of_the_models(
    folder: Path, comparison: MethodComparison
) -> None:
    data, prepared = table(folder / "figure_3.csv"), comparison.prepared[0]
    at_rows = np.searchsorted(prepared.recording.time, data["time"] - 1e-9)
    pso = comparison.results["pso"].torque[0][prepared.first_cycle]
    usable = np.isfinite(data["measured_voltage_1"])
    assert usable.mean() > 0.99
    for joint in range(3):
        np.testing.assert_allclose(
            data[f"measured_voltage_{joint + 1}"][usable],
            prepared.recording.voltage[at_rows, joint][usable],
            atol=1e-5,
        )
        computed = data[f"pso_voltage_{joint + 1}"]
        np.testing.assert_allclose(computed * np.abs(computed), pso[:, joint], rtol=1e-6)
    assert "manufacturer_voltage_1" in data


@pytest.mark.parametrize(
    ("number", "methods"),
    [(6, ["pso"]), (7, ["pso", "rls"]), (8, ["pso", "dls"]), (9, ["pso", "svd"]), (10, ["pso", "rls", "dls", "svd"])],
)
def test_data_of_the_other_figures_are_torques_by_method(
    number: int, methods: list[str], folder: Path, comparison: MethodComparison
) -> None:
    data, role = table(folder / f"figure_{number}.csv"), int(number == 10)
    prepared = comparison.prepared[role]
    assert list(data) == ["time", *(f"{name}_torque_{j}" for name in ["measured", *methods] for j in (1, 2, 3))]
    np.testing.assert_allclose(data["time"], prepared.time[prepared.first_cycle], rtol=1e-6)
    for name in methods:
        expected = comparison.results[name].torque[role][prepared.first_cycle, 1]
        np.testing.assert_allclose(data[f"{name}_torque_2"], expected, rtol=1e-6, atol=1e-9)
