"""`daq response`: record the frequency response of one axis."""

from pathlib import Path

import click

from daq.command_options import PACE, RATE, RIG, SEED, SIM
from recordings.command_line import FiniteRange

_FILE = click.Path(path_type=Path)


@click.command(
    name="response",
    short_help="Record a small multisine on one joint.",
    epilog="Example: daq response --joint 1 --rig bench.toml --out joint1.mcap, then: ident response joint1.mcap",
)
@click.option("--joint", type=click.IntRange(1), required=True, help="Joint that moves; the others hold.")
@RIG
@click.option(
    "--amplitude",
    type=FiniteRange(0, 0.1, min_open=True),
    default=0.03,
    show_default=True,
    help="Largest deviation from the middle of the workspace [rad].",
)
@click.option("--cycles", type=click.IntRange(2), default=3, show_default=True, help="Repetitions of 20 s.")
@RATE
@click.option("--out", type=_FILE, help="Recording to write.  [default: response-JOINT.mcap]")
@PACE
@SEED
@SIM
@click.option("--json", "as_json", is_flag=True, help="Figures as JSON on stdout.")
def command(
    joint: int,
    rig_file: Path | None,
    amplitude: float,
    cycles: int,
    rate: float | None,
    out: Path | None,
    pace: str | None,
    seed: int,
    sim_file: Path | None,
    as_json: bool,
) -> None:
    """Move one joint by a sum of small sines from 1 Hz to 0.4 of the rate, and record it like any motion.

    The joint stays within --amplitude, and below 0.7 of the speed and acceleration limits; the drives end disabled,
    as after `daq record`. `ident response` finds resonance and delay in the recording.
    """
    from daq.commands.record import record_trajectory
    from daq.cycle.session import rig_from
    from trajectories.multisine import multisine
    from trajectories.trajectory import assemble

    rig = rig_from(rig_file, rate)
    trajectory = assemble(multisine(rig, joint, amplitude), rig, cycles)
    record_trajectory(rig, trajectory, out, pace, seed, sim_file, as_json, "response")
