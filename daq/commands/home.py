"""`daq home`: let the drives search their zero."""

import json

import click

from daq.command_options import JSON, PACE, RIG, SIM, DriveOptions, drive_options
from recordings.command_line import IntegerRange, say_next, say_report


@click.command(
    name="home",
    short_help="Let the drives search their zero, one after the other.",
    epilog="Example: daq home --joint 2 --rig bench.toml",
)
@click.option("--joint", type=IntegerRange(1), help="Only this joint.  [default: one after the other]")
@click.option("--again", is_flag=True, help="Home drives that have their zero reference, too.")
@drive_options(RIG, PACE, SIM)
@JSON
def command(joint: int | None, again: bool, drives: DriveOptions, as_json: bool) -> None:
    """Home each drive that has `homing = { method = ... }` in the rig file, by its own homing mode (CiA 402 mode 6).

    The drive searches by itself, as its manual says of the method; the other joints hold. Ctrl-C is a quick stop. A
    drive with an absolute encoder needs no homing: leave the key out.
    """
    from daq.commissioning.homing import home
    from recordings.progress import progress_bar

    bench = drives.bench()
    joints = list(range(1, bench.rig.dof + 1)) if joint is None else [joint]
    units = {number: bench.unit(number) for number in joints}
    bench.announce("homing")
    outcomes = []
    with bench.serve(), progress_bar("homing") as show:
        for outcome in home(bench.rig, joints, bench.pace, say_report, again=again):
            show(f"joint {outcome.joint} done")
            outcomes.append(outcome)
            if not as_json:
                where = f"{outcome.position:.4f} {units[outcome.joint]}"
                done = f"homed by method {outcome.method}, stands at {where}"
                click.echo(f"joint {outcome.joint}: {outcome.reason or done}")
    if as_json:
        rows = [
            {"joint": o.joint, "method": o.method, "position": None if o.method is None else o.position}
            for o in outcomes
        ]
        click.echo(json.dumps({"schema": 1, "joints": rows}))
    say_next("daq", "check", *drives.words)
