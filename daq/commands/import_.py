"""`daq import`: conversion of measurements of another program to a recording."""

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from daq.importing import Description, Imported

_FILE = click.Path(path_type=Path)
_LONGEST_STEP = 0.05
"""Median time step above which a wrong unit of time is likely [s]."""
_EPILOG = """\b
Examples:
  daq import bench.csv --out bench.mcap --rig rig.toml
  daq import axis.csv --out axis.mcap --mechanism axes --joints prismatic --torque-map linear --gain 12.5"""


@click.command(short_help="Turn a CSV file of measurements into a recording.", epilog=_EPILOG)
@click.argument("file", metavar="DATA.csv", type=_FILE)
@click.option("--out", type=_FILE, required=True, help="Recording to write.")
@click.option("--rig", "rig_file", type=_FILE, help="Rig file (TOML) that says what was measured.")
@click.option(
    "--mechanism", type=click.Choice(["delta", "axes"]), help="Without a rig file.  [default: delta for 3 joints]"
)
@click.option(
    "--joints", metavar="KIND,...", help="revolute or prismatic, for all axes or one each.  [default: revolute]"
)
@click.option("--torque-map", type=click.Choice(["square", "linear"]), help="Torque = gain v|v|, or gain v.")
@click.option(
    "--gain", metavar="NUMBER,...", help="N m/V^2 or N m/V (N for prismatic joints), for all joints or one each."
)
@click.option("--kt", metavar="NUMBER,...", help="N m/A (N/A for prismatic joints) of current_i, one per joint.")
@click.option("--gravity", is_flag=True, help="Gravity loads the joint; of --mechanism axes with a single axis.")
@click.option("--simulated", is_flag=True, help="The measurements come from a simulation; the recording will say so.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on stdout.")
def command(
    file: Path,
    out: Path,
    rig_file: Path | None,
    mechanism: str | None,
    joints: str | None,
    torque_map: str | None,
    gain: str | None,
    kt: str | None,
    gravity: bool,
    simulated: bool,
    as_json: bool,
) -> None:
    """Turn measurements of another program into a recording for `ident`.

    DATA.csv has a header row and SI units: time (strictly increasing, even or not), position_1 ... position_n, and
    voltage_i, effort_i or current_i. Optional: velocity_i, command_i, temperature_i (degC), and cycle, the number of
    the repetition, or -1; without it repetitions are found from the motion. Other columns of numbers are kept. An
    empty cell or NaN is a gap.

    Three joints without --rig and --mechanism are the delta robot of the paper.
    """
    from daq.importing import import_csv

    torque = {
        **({"map": torque_map} if torque_map else {}),
        **({"gain": _numbers("--gain", gain)} if gain else {}),
        **({"per_ampere": _numbers("--kt", kt)} if kt else {}),
    }
    described = _description(rig_file, mechanism, joints, torque, gravity)
    imported = import_csv(file, out, replace(described, simulated=simulated))
    figures = _figures(imported, out)
    if (step := figures["step_s"]["median"]) > _LONGEST_STEP:
        click.echo(
            f"warning: a sample every {step:g} s ({1 / step:.3g} Hz) is too slow to identify a motion; the column "
            "time is in s: if it holds ms, divide it by 1000 and import it again",
            err=True,
        )
    if as_json:
        click.echo(json.dumps(figures))
    else:
        _show(figures, imported)


def _description(
    rig_file: Path | None, mechanism: Any, joints: str | None, torque: dict[str, Any], gravity: bool
) -> "Description":
    from daq.importing import Description
    from recordings.errors import BadInput
    from recordings.rig import load_rig

    if rig_file is not None:
        if any((mechanism, joints, torque, gravity)):
            options = "--mechanism, --joints, --torque-map, --gain, --kt, --gravity"
            raise BadInput(f"either --rig or {options} expected, both found")
        return Description(rig=load_rig(rig_file, driven=False))
    if joints is not None and mechanism != "axes":
        raise BadInput("--joints describes the axes of --mechanism axes; add it, or leave --joints out")
    return Description(mechanism=mechanism, joints=_kinds(joints), torque=torque or None, gravity=gravity)


def _kinds(joints: str | None) -> Any:
    from recordings.errors import BadInput

    kinds = tuple(kind.strip() for kind in (joints or "revolute").split(","))
    for kind in kinds:
        if kind not in ("revolute", "prismatic"):
            raise BadInput(f"--joints: revolute or prismatic expected, {kind!r} found")
    return kinds


def _numbers(option: str, text: str) -> list[float]:
    from recordings.errors import BadInput

    try:
        return [float(number) for number in text.split(",")]
    except ValueError:
        raise BadInput(f"{option}: numbers such as 1.0 or 1.0,0.9,1.1 expected, {text!r} found") from None


def _figures(imported: "Imported", out: Path) -> dict[str, Any]:
    import numpy as np

    steps, samples = imported.steps, imported.samples
    return {
        "schema": 1,
        "recording": str(out),
        "rig": imported.rig.name,
        "mechanism": imported.rig.mechanism,
        "joints": imported.rig.dof,
        "samples": len(samples.stamp),
        "duration_s": float(steps.sum()),
        "step_s": {"min": float(steps.min()), "median": float(np.median(steps)), "max": float(steps.max())},
        "gaps": np.isnan(samples.position).sum(axis=0).tolist(),
        "cycles": int(samples.repeat.max()) + 1,
        "period_s": imported.run.period,
        "extra": list(samples.extra),
    }


def _show(figures: dict[str, Any], imported: "Imported") -> None:
    step = {name: f"{value * 1e3:g} ms" for name, value in figures["step_s"].items()}
    cycles = f"{figures['cycles']} of {figures['period_s']:g} s" if figures["cycles"] else "none found"
    click.echo(f"joints: {figures['joints']} ({figures['mechanism']})")
    click.echo(f"samples: {figures['samples']} in {figures['duration_s']:g} s")
    click.echo(f"steps: {step['median']}, from {step['min']} to {step['max']}")
    click.echo(f"gaps: {', '.join(map(str, figures['gaps'])) if any(figures['gaps']) else 'none'}")
    click.echo(f"cycles: {cycles}")
    if figures["extra"]:
        click.echo(f"kept as extra channel: {', '.join(figures['extra'])}")
    if imported.samples.voltage is not None and imported.rig.torque.gain_source == "assumed":
        click.echo("torque gain: assumed, so a fit will be relative; a rig file can say otherwise", err=True)
    click.echo(f"imported {figures['recording']}; next: ident fit {figures['recording']}")
