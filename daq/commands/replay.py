"""`daq replay`: replay of the CAN frames of a recording on a bus."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from recordings.command_line import FiniteRange, IntegerRange, NameChoice, say, say_next
from recordings.errors import BadInput, RunFailed

if TYPE_CHECKING:
    from daq.passive.replay import Replayed, ReplayPlan
    from recordings.buses import CanBus

_EPILOG = """\b
Examples:
  daq replay run.mcap --bus socketcan:vcan0
  daq replay run.mcap --bus socketcan:vcan0 --direction both --yes --speed 2 --loop 3
  daq replay run.mcap --bus udp_multicast:239.74.163.2 --id 0x180/0x780"""


@click.command(short_help="Put a recording's CAN frames back on a bus.", epilog=_EPILOG)
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--bus",
    required=True,
    metavar="INTERFACE:CHANNEL[,KEY=VALUE...]",
    help="As in python-can, with its bitrate and options; udp_multicast:ADDRESS:PORT.",
)
@click.option("--speed", type=FiniteRange(0, min_open=True), default=1.0, show_default=True, help="Times as fast.")
@click.option("--loop", "loops", type=IntegerRange(1), default=1, show_default=True, help="Repetitions.")
@click.option("--id", "ids", multiple=True, metavar="ID", help="0x181, 0x181-0x183 or value/mask; may be repeated.")
@click.option(
    "--direction",
    type=NameChoice(["rx", "tx", "both"]),
    default="rx",
    show_default=True,
    help="What was received (the drives' answers), what was sent (the commands), or both.",
)
@click.option("--yes", is_flag=True, help="Send frames that command drives: no drive that could move is on the bus.")
@click.option("--json", "as_json", is_flag=True, help="Figures as JSON on stdout.")
def command(
    file: Path,
    bus: str,
    speed: float,
    loops: int,
    ids: tuple[str, ...],
    direction: Any,
    yes: bool,
    as_json: bool,
) -> None:
    """Put a recording's CAN frames back on a bus, in their order and with their timing.

    Frames that command drives (NMT, SYNC, targets, SDO requests) MOVE real drives, without limits or supervision:
    they are refused without --yes. Ctrl-C ends at once; nothing stops drives that were set in motion.
    """
    from daq.cycle.stopping import StopRequest, check_stoppable
    from daq.passive.replay import commanding, matching, plan, replay
    from drivers.canopen.bus import open_bus
    from recordings.buses import bus_from
    from recordings.progress import progress_bar
    from recordings.reader import read_can

    can_bus = bus_from(bus)
    if can_bus.interface == "virtual":
        raise BadInput("the virtual bus ends at this program; choose socketcan or udp_multicast")
    frames = read_can(file)
    chosen = matching(frames, direction, ids)
    plan_ = plan(frames, chosen, speed, loops, can_bus.bitrate)
    orders = int((commanding(frames) & chosen).sum())
    if orders and not yes:
        raise BadInput(
            f"{orders} of {len(plan_.rows)} frames command drives, and would MOVE real ones; choose others with "
            "--direction or --id, or add --yes if no drive that could move is on the bus"
        )
    if orders:
        check_stoppable()
    _announce(plan_, can_bus, orders, speed)
    with open_bus(can_bus) as opened, StopRequest() as stop, progress_bar("replaying") as show:
        result = replay(plan_, opened, stop, lambda sent: show(f"replaying: {sent} frames", sent, plan_.total))
    _show(result, plan_, as_json)
    if result.stopped:
        raise RunFailed(f"{result.stopped} after {result.sent} of {plan_.total} frames")
    say_next("daq", "info", file)


def _announce(plan_: "ReplayPlan", bus: "CanBus", orders: int, speed: float) -> None:
    what = f"{plan_.total} frames in {plan_.duration:.1f} s on {bus.interface} '{bus.channel}'"
    say(f"replaying {what}, {speed:g} times as fast as recorded")
    if orders:
        say(f"{orders} of {len(plan_.rows)} frames COMMAND DRIVES: any real drive on this bus will move", "red")


def _show(result: "Replayed", plan_: "ReplayPlan", as_json: bool) -> None:
    from recordings.recording import lateness_quantiles

    late = lateness_quantiles(result.lateness) if result.sent else dict.fromkeys(("p50", "p99", "max"), 0.0)
    if as_json:
        figures = {"frames": result.sent, "frames_planned": plan_.total, "lateness_s": late}
        click.echo(json.dumps({"schema": 1, **figures, "stopped": result.stopped}))
        return
    words = ", ".join(f"{name} {value * 1e3:.2f} ms" for name, value in late.items())
    click.echo(f"frames: {result.sent} of {plan_.total}")
    click.echo(f"lateness: {words}")
