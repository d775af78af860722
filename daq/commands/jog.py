"""`daq jog`: move one joint a little, slowly."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from daq.command_options import ACCEPT, FILE, PACE, RATE, RIG, SIM, DriveOptions, drive_options
from recordings.command_line import FiniteRange, IntegerRange, refuse_together, say, say_next, say_report
from recordings.errors import BadInput, RunFailed

if TYPE_CHECKING:
    from daq.commissioning.small_motion import Moved


@click.command(
    name="jog",
    short_help="Move one joint a little, slowly.",
    epilog="Example: daq jog --joint 2 --by 0.05 --rig bench.toml",
)
@click.option("--joint", type=IntegerRange(1), required=True, help="Joint that moves; the others hold.")
@click.option("--by", type=FiniteRange(-0.5, 0.5), required=True, help="How far [rad, or m].")
@click.option(
    "--speed", type=FiniteRange(0.05, 0.5), default=0.1, show_default=True, help="Joint speed [rad/s, or m/s]."
)
@click.option(
    "--hold",
    is_flag=True,
    help="Move only while a key is held: anything on standard input is a keep-alive. 0.3 s after the last one, and "
    "at the end of the input, the motion ramps down.",
)
@click.option("--out", type=FILE, help="Keep the recording.  [default: none is kept]")
@drive_options(RIG, RATE, PACE, SIM, ACCEPT)
@click.option("--json", "as_json", is_flag=True, help="Figures as JSON on stdout.")
@click.option("--status", is_flag=True, help="For a program that watches: the run as JSON lines on stdout.")
def command(
    joint: int,
    by: float,
    speed: float,
    hold: bool,
    out: Path | None,
    drives: DriveOptions,
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
    from daq.commissioning.small_motion import move
    from trajectories.small_moves import jog

    if by == 0:
        raise BadInput("--by: a way expected, 0 found; e.g. --by 0.05")
    refuse_together("--status", "--json", because="the lines of --status end with the figures of --json")
    bench = drives.bench()
    unit = bench.unit(joint)
    bench.announce(f"joint {joint} by {by:+g} {unit} at {speed:g} {unit}/s")
    if hold and sys.stdin.isatty():
        say("hold a key (such as the space bar) to move; release it to stop")
    with keys_unbuffered():
        moved = move(
            bench,
            lambda pose: jog(bench.rig, pose, joint, by, speed),
            out,
            say_report,
            hold=sys.stdin.fileno() if hold else None,
            status=status,
        )
    if moved.error is not None and not moved.released:
        raise RunFailed(moved.error)
    _show(moved, joint, by, unit, as_json or status)
    if not moved.released:
        moved.refuse_laggard(joint, unit)
    say_next("daq", "axis-check", "--joint", joint, *drives.words)


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
