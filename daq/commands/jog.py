"""`daq jog`: move one joint a little, slowly."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from daq.command_options import PACE, RATE, RIG, SIM
from recordings.command_line import FiniteRange, say, say_next

if TYPE_CHECKING:
    from daq.commissioning.small_motion import Moved

_FILE = click.Path(path_type=Path)


@click.command(
    name="jog",
    short_help="Move one joint a little, slowly.",
    epilog="Example: daq jog --joint 2 --by 0.05 --rig bench.toml",
)
@click.option("--joint", type=click.IntRange(1), required=True, help="Joint that moves; the others hold.")
@click.option("--by", type=FiniteRange(-0.5, 0.5), required=True, help="How far [rad, or m].")
@click.option(
    "--speed", type=FiniteRange(0.05, 0.5), default=0.1, show_default=True, help="Joint speed [rad/s, or m/s]."
)
@RIG
@click.option(
    "--hold",
    is_flag=True,
    help="Move only while a key is held: anything on standard input is a keep-alive. 0.3 s after the last one, and "
    "at the end of the input, the motion ramps down.",
)
@click.option("--out", type=_FILE, help="Keep the recording.  [default: none is kept]")
@RATE
@PACE
@SIM
@click.option("--json", "as_json", is_flag=True, help="Figures as JSON on stdout.")
@click.option("--status", is_flag=True, help="For a program that watches: the run as JSON lines on stdout.")
def command(
    joint: int,
    by: float,
    speed: float,
    rig_file: Path | None,
    hold: bool,
    out: Path | None,
    rate: float | None,
    pace: str | None,
    sim_file: Path | None,
    as_json: bool,
    status: bool,
) -> None:
    """Move one joint from where it stands, slowly and supervised, and switch the drives off again.

    The way is compared with the limits of the rig file before power. Ctrl-C ramps down and disables the drives;
    Ctrl-C twice is a quick stop. Look at the joint: a positive angle lifts the elbow of a delta robot, and 0.05 rad
    are 2.9 degrees.
    """
    import sys

    from daq.commissioning.hold import keys_unbuffered
    from daq.commissioning.small_motion import Machine, move
    from daq.cycle.session import rig_from
    from recordings.errors import BadInput, RunFailed
    from trajectories.small_moves import jog

    if by == 0:
        raise BadInput("--by: a way expected, 0 found; e.g. --by 0.05")
    if status and as_json:
        raise BadInput("--status ends with the figures of --json; drop one of them")
    machine = Machine.of(rig_from(rig_file, rate), pace, sim_file)
    machine.announce(f"joint {joint} by {by:+g} {machine.unit(joint)} at {speed:g} {machine.unit(joint)}/s")
    if hold and sys.stdin.isatty():
        say("hold a key (such as the space bar) to move; release it to stop")
    with keys_unbuffered():
        moved = move(
            machine,
            lambda pose: jog(machine.rig, pose, joint, by, speed),
            out,
            lambda level, source, message: say(f"{level}: {source}: {message}"),
            hold=sys.stdin.fileno() if hold else None,
            status=status,
        )
    if moved.error is not None and not moved.released:
        raise RunFailed(moved.error)
    _show(moved, joint, by, machine.unit(joint), as_json or status)
    say_next("daq", "axis-check", "--joint", joint, *(("--rig", rig_file) if rig_file else ()))


def _show(moved: "Moved", joint: int, by: float, unit: str, as_json: bool) -> None:
    start, end = moved.ends(joint)
    if as_json:
        document = {"schema": 1, "joint": joint, "from": start, "to": end, "by": by, "released": moved.released}
        click.echo(json.dumps(document))
        return
    early = ", released" if moved.released else ""
    click.echo(
        f"joint {joint}: from {start:.4f} to {end:.4f} {unit}, {end - start:+.4f} of {by:+g}{early}; drives off"
    )
