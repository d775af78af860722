"""`daq axis-check`: compare sign, scale and torque of each axis with the rig file by a small swing."""

import json
from typing import TYPE_CHECKING

import click

from daq.command_options import JSON, PACE, RATE, RIG, SIM, DriveOptions, drive_options
from recordings.command_line import FiniteRange, say_next, say_report
from recordings.errors import RunFailed

if TYPE_CHECKING:
    from daq.commissioning.axis_check import AxisFigures
    from drivers.protocol import CheckResult


@click.command(
    name="axis-check",
    short_help="Swing each joint a little: are sign, scale and torque as in the rig file?",
    epilog="Example: daq axis-check --rig bench.toml",
)
@click.option("--joint", type=click.IntRange(1), help="Only this joint.  [default: one after the other]")
@click.option(
    "--amplitude",
    type=FiniteRange(0.01, 0.2),
    default=0.05,
    show_default=True,
    help="Deviation to both sides of where the joint stands [rad, or m].",
)
@drive_options(RIG, RATE, PACE, SIM)
@JSON
def command(joint: int | None, amplitude: float, drives: DriveOptions, as_json: bool) -> None:
    """Swing one joint after the other about where it stands, and judge weight, inertia and friction in the torque.

    Named are: a position that runs against its command, a torque with the wrong polarity, a wrong sign, a joint that
    moves further or less than commanded (counts_per_turn, gear), and a torque gain that is off by more than 2. Run
    `daq jog` first: it is slower. Exit code 1 where a contradiction was found.
    """
    from functools import partial

    from daq.commissioning.axis_check import figures_of, judge
    from daq.commissioning.small_motion import move
    from trajectories.small_moves import swing

    bench = drives.bench()
    figures: list[AxisFigures] = []
    results: list[CheckResult] = []
    for number in range(1, bench.rig.dof + 1) if joint is None else [joint]:
        bench.announce(f"joint {number} by ±{amplitude:g} {bench.unit(number)}")
        plan = partial(swing, bench.rig, joint=number, amplitude=amplitude)
        moved = move(bench, plan, None, say_report, hold=None, status=False)
        if moved.error is not None:
            raise RunFailed(f"{moved.error}{moved.contradiction(number)}")
        figures.append(figures_of(moved.recording, plan(moved.pose), number))
        results += judge(figures[-1], bench.rig)
    problems = [result for result in results if result.verdict == "problem"]
    _print(figures, results, as_json)
    if problems:
        raise RunFailed(f"{len(problems)} contradiction(s) found; correct the rig file or the drive")
    say_next("daq", "record", "--traj", "fig5a", *drives.words)


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
        table.add_row(str(f.joint), f"{f.travel:.0%}", weight, travel, f"{f.friction:.2f}")
    console = Console()
    console.print(table)
    if all(result.verdict == "fine" for result in results):
        console.print("nothing contradicts the rig file")
    for result in results:
        if result.verdict != "fine":
            colour = "red" if result.verdict == "problem" else None
            console.print(f"{result.where}, {result.what}: {result.found}", style=colour, highlight=False)
