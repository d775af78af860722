"""Draw Figures 3 and 6 to 10 of the paper with the given recordings, and write what they show as CSV."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.dynamics.torque_map import voltage_from_torque
from ident.output.pictures import curves
from ident.paper.methods import BASELINES, MANUFACTURER, MethodComparison
from recordings.recording import Floats

_IDENTIFICATION, _VALIDATION = 0, 1


def draw(comparison: MethodComparison, folder: Path) -> None:
    """Draw all figures into `folder`, named by their numbers in the paper, each with its data beside it.

    Figure 3 shows operating voltages, as the paper does, the others torques.
    """
    identification, validation = comparison.prepared
    computed = {name: result.torque[_IDENTIFICATION] for name, result in comparison.results.items()}
    assert identification.nominal is not None
    _draw_voltage(folder, identification, {MANUFACTURER: identification.nominal, "pso": computed["pso"]})
    pso = {"pso": computed["pso"]}
    _draw_torque(folder, 6, "measured, and identified by PSO", identification, pso)
    for number, method in zip((7, 8, 9), BASELINES, strict=True):
        title = f"measured, identified by {method.upper()}, identified by PSO"
        _draw_torque(folder, number, title, identification, {**pso, method: computed[method]})
    validated = {name: comparison.results[name].torque[_VALIDATION] for name in ("pso", *BASELINES)}
    _draw_torque(folder, 10, "validation on another motion", validation, validated)


def _draw_voltage(folder: Path, prepared: PreparedRecording, torques: Mapping[str, Floats]) -> None:
    """Figure 3: the actual operating voltage, and that of each of the `torques` (m, dof), with the torque's sign."""
    torque_map = prepared.recording.rig.torque
    actual = voltage_from_torque(prepared.torque, torque_map)
    voltages = {name: voltage_from_torque(torque, torque_map) for name, torque in torques.items()}
    title = "Figure 3: (a) manufacturer's model, (b) model identified by PSO"
    columns = [{name: voltage} for name, voltage in voltages.items()]
    curves(folder / "figure_3.png", title, prepared, actual, columns, ["voltage [V]"] * actual.shape[1])
    _write(folder / "figure_3.csv", prepared, "voltage", {"measured": actual, **voltages})


def _draw_torque(
    folder: Path, number: int, title: str, prepared: PreparedRecording, torques: Mapping[str, Floats]
) -> None:
    quantities = ["torque [N m]"] * prepared.torque.shape[1]
    curves(
        folder / f"figure_{number}.png", f"Figure {number}: {title}", prepared, prepared.torque, [torques], quantities
    )
    _write(folder / f"figure_{number}.csv", prepared, "torque", {"measured": prepared.torque, **torques})


def _write(path: Path, prepared: PreparedRecording, quantity: str, shown: Mapping[str, Floats]) -> None:
    """Write the rows that a figure shows: `time` [s], and NAME_QUANTITY_JOINT for each of its curves (m, dof)."""
    rows, dof = prepared.first_cycle, prepared.torque.shape[1]
    header = ["time", *(f"{name}_{quantity}_{joint}" for name in shown for joint in range(1, dof + 1))]
    write_csv(path, header, np.column_stack([prepared.time[rows], *(values[rows] for values in shown.values())]))


def write_csv(path: Path, header: Sequence[str], rows: Floats | Sequence[Sequence[object]]) -> None:
    """Write a table with a header row; a missing number is empty."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(header)
        writer.writerows([_cell(value) for value in row] for row in rows)


def _cell(value: object) -> object:
    if isinstance(value, float):
        return "" if np.isnan(value) else f"{value:.9g}"
    return value
