"""`daq axis-check`: compare sign, scale and torque of each axis with the rig file by a small swing."""

import json
from typing import TYPE_CHECKING

import click

from daq.command_options import ACCEPT, JSON, PACE, RATE, RIG, SIM, DriveOptions, drive_options, say_next_recording
from recordings.command_line import FiniteRange, IntegerRange, say
from recordings.errors import BadInput, RunFailed

if TYPE_CHECKING:
    from daq.commissioning.axis_check import AxisFigures
    from drivers.protocol import CheckResult


@click.command(
    name="axis-check",
    short_help="Swing each joint a little: are sign, scale and torque as in the rig file?",
    epilog="Example: daq axis-check --rig bench.toml",
)
@click.option("--joint", type=IntegerRange(1), help="Only this joint.  [default: one after the other]")
@click.option(
    "--amplitude",
    type=FiniteRange(0.01, 0.2),
    default=0.05,
    show_default=True,
    help="Deviation to both sides of where the joint stands [rad, or m].",
)
@click.option(
    "--travel",
    type=FiniteRange(0, 1, min_open=True),
    metavar="RAD",
    help="With --joint: true angle between the ends of the swing, as measured from outside, e.g. between two stops.",
)
@click.option(
    "--payload",
    type=FiniteRange(0, 100, min_open=True),
    metavar="KG",
    help="Known mass: swing again when it is fixed to the platform, which proves the torque gain.",
)
@click.option("--write", is_flag=True, help="Put what was found into the rig file; its comments stay.")
@drive_options(RIG, RATE, PACE, SIM, ACCEPT)
@JSON
def command(
    joint: int | None,
    amplitude: float,
    travel: float | None,
    payload: float | None,
    write: bool,
    drives: DriveOptions,
    as_json: bool,
) -> None:
    """Swing one joint after the other about where it stands, and judge weight, inertia and friction in the torque.

    Each quantity is proved, by a reference that is named, consistent, not shown, or a problem: a position that runs
    against its command, a torque with the wrong polarity, a wrong sign, counts_per_turn, gear or torque gain. Then a
    quick stop from slow motion shows the unit of its deceleration (6085h). Run `daq jog` first: it is slower. Exit
    code 1 where a contradiction was found.
    """
    from daq.commissioning.axis_check import changes, judge, measured
    from daq.commissioning.axis_swings import AxisSwings
    from daq.commissioning.rig_edit import write_changes

    bench = drives.bench()
    if travel is not None and joint is None:
        raise BadInput("--travel belongs to one joint; add --joint")
    if write and drives.rig_file is None:
        raise BadInput("--write changes a rig file; add --rig")
    if payload is not None and bench.rig.mechanism != "delta":
        raise BadInput("--payload is a mass on the platform of a delta robot; use --travel and your eyes")
    if payload is not None and any(drive.torque_source == "none" for drive in bench.rig.drives):
        raise BadInput('--payload is weighed by the torque, torque_source = "none" found; leave it out')
    joints = list(range(1, bench.rig.dof + 1)) if joint is None else [joint]
    figures = AxisSwings(bench, amplitude).figures(joints, travel, payload)
    judged = [(f, list(judge(f, bench.rig))) for f in figures]
    results = [result for _, found in judged for result in found]
    _print(figures, results, as_json)
    problems = [result for result in results if result.verdict == "problem"]
    found = [*changes(judged, bench.rig), *measured(judged)]
    if write and drives.rig_file is not None:
        if found:
            write_changes(drives.rig_file, found)
        text = ", ".join(map(str, found)) or "no value to write"
        say(f"{drives.rig_file}: {text}{'; run the check again' if found and problems else ''}")
    if problems:
        raise RunFailed(f"{len(problems)} contradiction(s) found; correct the rig file or the drive")
    say_next_recording(bench.rig, drives)


def _print(figures: "list[AxisFigures]", results: "list[CheckResult]", as_json: bool) -> None:
    from dataclasses import asdict

    from rich.console import Console
    from rich.table import Table

    if as_json:
        document = {"schema": 1, "axes": [asdict(f) for f in figures], "findings": [asdict(r) for r in results]}
        click.echo(json.dumps(document, indent=1))
        return
    table = Table("joint", "follows", "weight", "true travel", "friction [N m]", box=None)
    for f in figures:
        weight = "unknown" if f.weight is None else f"{f.weight:.2f} x"
        # Of weight over that of the masses, and inertia likewise: the ratio is the true travel over the command.
        travel = "unknown" if f.weight is None or f.inertia is None else f"{f.inertia / f.weight:.2f} x"
        friction = "unknown" if f.friction is None else f"{f.friction:.2f}"
        table.add_row(str(f.joint), f"{f.travel:.0%}", weight, travel, friction)
    console = Console(markup=False)
    console.print(table)
    for result in results:
        colour = "red" if result.verdict == "problem" else None
        line = f"{result.where}, {result.what}: {result.verdict}, {result.found}"
        console.print(line, style=colour, highlight=False)
    if all(result.verdict != "problem" for result in results):
        console.print("nothing contradicts the rig file")
