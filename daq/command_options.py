"""Options that several commands of `daq` have in common."""

from pathlib import Path

import click

_FILE = click.Path(path_type=Path)

RIG = click.option("--rig", "rig_file", type=_FILE, help="Rig file (TOML). Without it: the simulated rig.")
RATE = click.option("--rate", type=float, help="Cycles per second [Hz].  [default: the rig's]")
PACE = click.option(
    "--pace", type=click.Choice(["lockstep", "realtime"]), help="Simulated rig only.  [default: lockstep]"
)
SEED = click.option(
    "--seed", type=click.IntRange(0), default=0, show_default=True, help="Noise of the simulated rig."
)
SIM = click.option("--sim", "sim_file", type=_FILE, help="Sim file (TOML): what the simulated machine really is.")
