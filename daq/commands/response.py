"""`daq response`: record the frequency response of one axis."""

from pathlib import Path

import click

from daq.command_options import ACCEPT, FILE, JSON, PACE, RATE, RIG, SEED, SIM, DriveOptions, drive_options
from recordings.command_line import FiniteRange, IntegerRange


@click.command(
    name="response",
    short_help="Record a small multisine on one joint.",
    epilog="Example: daq response --joint 1 --rig bench.toml --out joint1.mcap, then: ident response joint1.mcap",
)
@click.option("--joint", type=IntegerRange(1), required=True, help="Joint that moves; the others hold.")
@click.option(
    "--amplitude",
    type=FiniteRange(0, 0.1, min_open=True),
    default=0.03,
    show_default=True,
    help="Largest deviation from the middle of the workspace [rad].",
)
@click.option("--cycles", type=IntegerRange(2), default=3, show_default=True, help="Repetitions of 20 s.")
@click.option("--out", type=FILE, help="Recording to write.  [default: response-JOINT.mcap]")
@drive_options(RIG, RATE, PACE, SEED, SIM, ACCEPT)
@JSON
def command(joint: int, amplitude: float, cycles: int, out: Path | None, drives: DriveOptions, as_json: bool) -> None:
    """Move one joint by a sum of small sines from 1 Hz to 0.4 of the rate, and record it like any motion.

    The joint stays within --amplitude, and below 0.7 of the speed and acceleration limits; the drives end disabled,
    as after `daq record`. `ident response` finds resonance and delay in the recording.
    """
    from daq.live.recording import record
    from trajectories.multisine import multisine
    from trajectories.trajectory import assemble

    bench = drives.bench()
    trajectory = assemble(multisine(bench.rig, joint, amplitude), bench.rig, cycles)
    record(bench, trajectory, out, "response", as_json=as_json)
