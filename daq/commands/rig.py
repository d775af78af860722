"""`daq rig`: rig files."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from daq.command_options import FILE
from recordings.command_line import refuse_existing, say, say_next
from recordings.errors import BadInput, RunFailed

if TYPE_CHECKING:
    from daq.proposal.facts import DriveFacts
    from recordings.buses import CanBus


@click.group(name="rig", short_help="Propose a rig file.")
def command() -> None:
    """Rig files: the description of the machine and its drives."""


@command.command(
    name="propose",
    short_help="Propose a rig file from EDS or DCF files, or from the drives.",
    epilog="Example: daq rig propose --eds drive.eds --bus socketcan:can0 --out rig.toml",
)
@click.option("--eds", type=FILE, multiple=True, help="EDS or DCF of the drives: one for all, or one per joint.")
@click.option("--scan", is_flag=True, help="Read the drives on the bus; nothing is written to them, nothing moves.")
@click.option(
    "--bus",
    default="socketcan:can0",
    show_default=True,
    metavar="INTERFACE:CHANNEL",
    help="CAN bus, as in python-can; udp_multicast:ADDRESS:PORT.",
)
@click.option("--nodes", default="1,2,3", show_default=True, help="Node id of each joint, with --eds.")
@click.option("--out", type=FILE, default=Path("rig.toml"), show_default=True, help="Rig file to write.")
@click.option("--force", is_flag=True, help="Replace the file.")
def propose(eds: tuple[Path, ...], scan: bool, bus: str, nodes: str, out: Path, force: bool) -> None:
    """Write a commented rig file: units, modes, PDO map, what the torque is found from, limits, what is missing.

    An EDS describes a type of drives; --scan reads the settings of yours. Every value says where it comes from; what
    nothing says is "?", to be filled in. Lines that need a decision are commented out.
    """
    from daq.proposal.document import propose as proposal_of
    from drivers import transports
    from recordings.buses import bus_from

    if scan == bool(eds):
        raise BadInput("either --eds FILE or --scan expected; an EDS describes the type, --scan reads your drives")
    refuse_existing(out, force=force, read=eds)
    can_bus = bus_from(bus)
    proposal = proposal_of(_drives(eds, can_bus, nodes), can_bus)
    out.write_text(proposal.text, encoding="utf-8")
    for note in proposal.notes:
        say(f"note: {note}", "yellow")
    click.echo(f"{len(proposal.rig.drives)} drives, {transports.of(proposal.rig).describe(proposal.rig)}")
    unknown = ', and put a value in place of each "?"' if proposal.asks else ""
    click.echo(f"written {out}; read its comments{unknown}")
    say_next("daq", "check", "--rig", out)


def _drives(eds: Sequence[Path], bus: "CanBus", nodes: str) -> "list[DriveFacts]":
    from daq.proposal.facts import from_bus, from_file

    if not eds:
        drives = from_bus(bus)
        if not drives:
            raise RunFailed("no CiA 402 drive answers; check power, cable, termination and bit rate")
        return drives
    try:
        node_ids = [int(node) for node in nodes.split(",")]
    except ValueError:
        raise BadInput(f"--nodes: node ids such as 1,2,3 expected, {nodes!r} found") from None
    if len(set(node_ids)) != len(node_ids) or not all(1 <= node <= 127 for node in node_ids):
        raise BadInput(f"--nodes: different node ids from 1 to 127 expected, {nodes!r} found")
    if len(eds) not in (1, len(node_ids)):
        raise BadInput(f"--eds: one file for all joints or {len(node_ids)} (as --nodes) expected, {len(eds)} found")
    paths = [*eds] * len(node_ids) if len(eds) == 1 else eds
    return [from_file(path, node) for path, node in zip(paths, node_ids, strict=True)]
