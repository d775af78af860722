"""`daq trajectories`: list of the trajectories, and a description and picture of one of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recordings.command_line import IntegerRange, refuse_existing, say_next

if TYPE_CHECKING:
    from recordings.rig import Rig
    from trajectories import Trajectory

EPILOG = """\b
Examples:
  daq trajectories
  daq trajectories fig5a --out fig5a.png
  daq trajectories my_path.csv --rig rig.toml --out my_path.png"""


@click.command(epilog=EPILOG)
@click.argument("name_or_file", required=False)
@click.option("--out", type=click.Path(path_type=Path), help="Draw the trajectory into this PNG file.")
@click.option("--force", is_flag=True, help="Replace an existing PNG file.")
@click.option("--rig", "rig_file", type=click.Path(path_type=Path), help="Rig file; without it, the simulated rig.")
@click.option("--cycles", type=IntegerRange(min=1), help="Repetitions; without it, about 20 seconds.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document.")
def command(
    name_or_file: str | None, out: Path | None, force: bool, rig_file: Path | None, cycles: int | None, as_json: bool
) -> None:
    """List the trajectories, or describe and draw one of them.

    NAME_OR_FILE is a name from the list, a CSV file (time,x,y,z in s and m, or time,joint_1,...,joint_n in s and
    rad), or a TOML file with a Fourier series. Nothing moves.
    """
    from recordings.rig import load_rig, simulated_rig
    from trajectories import load, names

    if out:
        _check_output(name_or_file, out)
    rig = load_rig(rig_file, driven=False) if rig_file else simulated_rig()
    loaded = [load(name, rig, cycles) for name in ([name_or_file] if name_or_file else names())]
    figures = [_figures(trajectory, rig) for trajectory in loaded]
    if out:
        refuse_existing(out, force=force)
        from trajectories.drawing import draw

        draw(loaded[0], rig).savefig(out, format="png")
    _show(figures, rig, out, as_json)
    name = name_or_file or "fig5a"
    possible = [name_or_file or row["name"] for row in figures if not row["refused"]]
    if name in possible and not as_json:
        say_next("daq", "record", "--traj", name, *(("--rig", rig_file) if rig_file else ()))


def _check_output(name_or_file: str | None, out: Path) -> None:
    from recordings.errors import BadInput

    if name_or_file is None:
        raise click.UsageError("--out draws one trajectory: name it, as in 'daq trajectories fig5a --out fig5a.png'")
    if out.suffix.lower() != ".png":
        raise BadInput(f"a file name ending in .png expected, {out} found")


def _figures(trajectory: Trajectory, rig: Rig) -> dict[str, Any]:
    import numpy as np

    from trajectories.checks import LimitExceeded, check, torque_estimate

    try:
        check(trajectory, rig)
        refused = None
    except LimitExceeded as error:
        refused = str(error)
    return {
        "name": trajectory.name,
        "description": trajectory.description,
        "digest": trajectory.digest,
        "duration_s": float(trajectory.time[-1]),
        "period_s": trajectory.period,
        "cycles": trajectory.cycles,
        "rate_hz": trajectory.rate,
        "max_speed_rad_s": np.abs(trajectory.joint_velocity).max(axis=0).tolist(),
        "max_acceleration_rad_s2": np.abs(trajectory.joint_acceleration).max(axis=0).tolist(),
        "max_torque_estimate_nm": np.abs(torque_estimate(trajectory, rig)).max(axis=0).tolist(),
        "refused": refused,
    }


def _show(figures: list[dict[str, Any]], rig: Rig, out: Path | None, as_json: bool) -> None:
    import json

    from rich.console import Console
    from rich.table import Table

    if as_json:
        drawing = str(out) if out else None
        click.echo(json.dumps({"schema": 1, "rig": rig.name, "trajectories": figures, "drawing": drawing}, indent=2))
        return
    table = Table(title=f"Rig: {rig.name}", title_justify="left", box=None, pad_edge=False)
    table.add_column("name", style="bold", no_wrap=True)
    for heading in ("duration\ns", "period\ns", "cycles", "speed\nrad/s", "accel.\nrad/s²", "torque\nN m"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("what it is")
    for row in figures:
        peaks = (max(row[key]) for key in ("max_speed_rad_s", "max_acceleration_rad_s2", "max_torque_estimate_nm"))
        period = f"{row['period_s']:g}" if row["period_s"] else "once"
        numbers = (f"{row['duration_s']:.1f}", period, str(row["cycles"]), *(f"{peak:.1f}" for peak in peaks))
        table.add_row(row["name"], *numbers, row["description"])
    console = Console(highlight=False, markup=False)
    console.print(table)
    console.print("Speed, acceleration and torque (a frictionless estimate): the largest of any joint.", style="dim")
    for row in figures:
        if row["refused"]:
            console.print(f"This rig would refuse it: {row['refused']}", style="red", soft_wrap=True)
    if out:
        console.print(f"Drawn into {out}", soft_wrap=True)
