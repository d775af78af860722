"""`python -m tests.foreign FOLDER --effect stribeck --size 0.03 --seed 1`."""

from pathlib import Path
from typing import Literal

import click

from drivers.simulated.effect import library
from drivers.simulated.seal import seal, sealed_path
from recordings.command_line import say_next
from tests.foreign.pairs import TRAIN, Setting, make
from tests.foreign.plant import KINDS
from tests.foreign.robots import Kind


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--effect", "effects", multiple=True, type=click.Choice([*library(), *KINDS]), help="May be repeated.")
@click.option("--size", default=0.03, show_default=True, help="Size of each effect, as a share of the torque.")
@click.option("--seed", default=1, show_default=True)
@click.option(
    "--robot", type=click.Choice(["default", "heavy", "light", "any"]), default="default", show_default=True
)
@click.option("--noise", default=0.01, show_default=True, help="Standard deviation of the voltage noise [V].")
@click.option("--bits", default=18, show_default=True, help="Encoder resolution per turn of the joint.")
@click.option("--rate", default=500.0, show_default=True, help="Sampling rate [Hz].")
@click.option(
    "--command",
    "reports_command",
    is_flag=True,
    help="Record commanded voltages, before the effects of the amplifiers.",
)
@click.option("--repeats/--no-repeats", default=True, show_default=True, help="Whether the motions repeat.")
@click.option("--signal", type=click.Choice(["voltage", "effort"]), default="voltage", show_default=True)
@click.option("--signal-bits", type=click.IntRange(1), help="Resolution of this signal.  [default: no steps]")
def main(
    folder: Path,
    effects: tuple[str, ...],
    size: float,
    seed: int,
    robot: Kind,
    noise: float,
    bits: int,
    rate: float,
    reports_command: bool,
    repeats: bool,
    signal: Literal["voltage", "effort"],
    signal_bits: int | None,
) -> None:
    """Write a pair of recordings of a robot with these effects, and the sealed truth, into the new FOLDER."""
    folder.mkdir(parents=True)
    setting = Setting(robot, noise, bits, rate, reports_command, repeats, signal, signal_bits)
    truth = make(folder, effects, [size] * len(effects), seed, setting)
    seal(sealed_path(folder / TRAIN), truth)
    click.echo(f"{folder}: train.mcap, validate.mcap")
    say_next("ident", "diagnose", folder / "train.mcap", "--validate", folder / "validate.mcap")


main()
