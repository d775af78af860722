"""`daq rig`: rig files."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from daq.command_options import FILE
from recordings.command_line import IntegerRange, NameChoice, output_name, refuse_existing, say, say_next
from recordings.errors import BadInput

if TYPE_CHECKING:
    from daq.proposal.facts import DriveFacts
    from drivers.canopen.lss import Identification
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
    metavar="INTERFACE:CHANNEL[,KEY=VALUE...]",
    help="CAN bus, as in python-can, with its bitrate and options; udp_multicast:ADDRESS:PORT.",
)
@click.option(
    "--nodes",
    default="1,2,3",
    show_default=True,
    help="Node id of each joint, with --eds; once more for each further axis of a node.",
)
@click.option(
    "--torque",
    type=NameChoice(["best", "none"]),
    default="best",
    show_default=True,
    help="What the torque is found from; none: positions only, for commissioning.",
)
@click.option("--out", type=FILE, help="Rig file to write.  [default: rig.toml]")
@click.option("--force", is_flag=True, help="Replace the file.")
def propose(
    eds: tuple[Path, ...], scan: bool, bus: str, nodes: str, torque: str, out: Path | None, force: bool
) -> None:
    """Write a commented rig file: units, modes, PDO map, what the torque is found from, limits, what is missing.

    An EDS describes a type of drives; --scan reads the settings of yours. Every value says where it comes from; what
    nothing says is "?", to be filled in. Lines that need a decision are commented out.
    """
    from daq.proposal.document import propose as proposal_of
    from drivers import transports
    from drivers.canopen.bus import check_interface
    from recordings.buses import bus_from

    if scan == bool(eds):
        raise BadInput("either --eds FILE or --scan expected; an EDS describes the type, --scan reads your drives")
    can_bus = bus_from(bus)
    check_interface(can_bus)
    out = output_name(out, Path("rig.toml"), force)
    refuse_existing(out, force=force, read=eds)
    proposal = proposal_of(_drives(eds, can_bus, nodes), can_bus, "none" if torque == "none" else None)
    out.write_text(proposal.text, encoding="utf-8")
    for note in proposal.notes:
        say(f"note: {note}", "yellow")
    click.echo(f"{len(proposal.rig.drives)} drives, {transports.of(proposal.rig).describe(proposal.rig)}")
    unknown = ', and put a value in place of each "?"' if proposal.asks else ""
    click.echo(f"written {out}; read its comments{unknown}")
    say_next("daq", "check", "--rig", out)


@command.command(
    name="lss",
    short_help="Give a device its node id and bit rate by LSS.",
    epilog="Example: daq rig lss --bus socketcan:can0 --node 3",
)
@click.option(
    "--bus",
    required=True,
    metavar="INTERFACE:CHANNEL[,KEY=VALUE...]",
    help="CAN bus, as in python-can, with its bitrate and options.",
)
@click.option("--node", type=IntegerRange(1, 127), required=True, help="Node id that the device gets.")
@click.option(
    "--bitrate",
    type=IntegerRange(1),
    help="Bit rate that it gets, from the table of CiA 305 [bit/s].  [default: as it is]",
)
@click.option(
    "--device",
    metavar="VENDOR,PRODUCT,REVISION,SERIAL",
    help="Numbers of 1018h of the device.  [default: the only one on the bus]",
)
def lss(bus: str, node: int, bitrate: int | None, device: str | None) -> None:
    """Give a device on the bus its node id, and its bit rate if asked, and let it store both (CiA 305).

    Nothing moves. Both take effect when the supply of the device is switched off and on.
    """
    from contextlib import closing

    from drivers.canopen.bus import Link, open_bus
    from drivers.canopen.discovery import check_no_other_master
    from drivers.canopen.lss import configure
    from recordings.buses import bus_from

    named = None if device is None else _identification(device)
    with closing(Link(open_bus(bus_from(bus)))) as link:
        check_no_other_master(link)
        numbers = configure(link, named, node, bitrate)
    listed = ", ".join(f"0x{number:X}" for number in numbers)
    rate = "" if bitrate is None else f" and {bitrate} bit/s"
    click.echo(f"device {listed}: node id {node}{rate} stored; switch its supply off and on")


def _identification(text: str) -> "Identification":
    try:
        vendor, product, revision, serial = (int(part, 0) for part in text.split(","))
    except ValueError:
        raise BadInput(f"--device: four numbers such as 0xAB,0xCD,0x10001,1234 expected, {text!r} found") from None
    return vendor, product, revision, serial


def _drives(eds: Sequence[Path], bus: "CanBus", nodes: str) -> "list[DriveFacts]":
    from daq.proposal.facts import from_bus, from_file
    from drivers.canopen.node_axes import AXES

    if not eds:
        return from_bus(bus)
    try:
        node_ids = [int(node) for node in nodes.split(",")]
    except ValueError:
        raise BadInput(f"--nodes: node ids such as 1,2,3 expected, {nodes!r} found") from None
    axes = [node_ids[: i + 1].count(node) for i, node in enumerate(node_ids)]
    if not all(1 <= node <= 127 for node in node_ids) or max(axes) > AXES:
        raise BadInput(
            f"--nodes: node ids from 1 to 127 expected, each once per axis, {AXES} times at most, {nodes!r} found"
        )
    if len(eds) not in (1, len(node_ids)):
        raise BadInput(f"--eds: one file for all joints or {len(node_ids)} (as --nodes) expected, {len(eds)} found")
    paths = [*eds] * len(node_ids) if len(eds) == 1 else eds
    return [from_file(*each) for each in zip(paths, node_ids, axes, strict=True)]
