"""`daq home`: let the drives search their zero."""

import json
from pathlib import Path

import click

from daq.command_options import PACE, RIG, SIM
from recordings.command_line import say, say_next


@click.command(
    name="home",
    short_help="Let the drives search their zero, one after the other.",
    epilog="Example: daq home --joint 2 --rig bench.toml",
)
@click.option("--joint", type=click.IntRange(1), help="Only this joint.  [default: one after the other]")
@RIG
@click.option("--again", is_flag=True, help="Home drives that have their zero reference, too.")
@PACE
@SIM
@click.option("--json", "as_json", is_flag=True, help="Outcomes as JSON on stdout.")
def command(
    joint: int | None, rig_file: Path | None, again: bool, pace: str | None, sim_file: Path | None, as_json: bool
) -> None:
    """Home each drive that has `homing = { method = ... }` in the rig file, by its own homing mode (CiA 402 mode 6).

    The drive searches by itself, as its manual says of the method; the other joints hold. Ctrl-C is a quick stop. A
    drive with an absolute encoder needs no homing: leave the key out.
    """
    from daq.commissioning.homing import home
    from daq.commissioning.small_motion import Machine
    from daq.cycle.session import rig_from
    from recordings.progress import progress_bar

    machine = Machine.of(rig_from(rig_file), pace, sim_file)
    joints = list(range(1, machine.rig.dof + 1)) if joint is None else [joint]
    for number in joints:
        machine.unit(number)
    machine.announce("homing")
    outcomes = []
    with machine.serve(Path("unused.sealed.json")), progress_bar("homing") as show:
        for outcome in home(
            machine.rig,
            joints,
            machine.pace,
            lambda level, source, message: say(f"{level}: {source}: {message}"),
            again=again,
        ):
            show(f"joint {outcome.joint} done")
            outcomes.append(outcome)
            if not as_json:
                unit = machine.unit(outcome.joint)
                done = f"homed by method {outcome.method}, stands at {outcome.position:.4f} {unit}"
                click.echo(f"joint {outcome.joint}: {outcome.reason or done}")
    if as_json:
        rows = [
            {"joint": o.joint, "method": o.method, "position": None if o.method is None else o.position}
            for o in outcomes
        ]
        click.echo(json.dumps({"schema": 1, "joints": rows}))
    say_next("daq", "check", *(("--rig", rig_file) if rig_file else ()))
