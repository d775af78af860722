"""`daq sim`: simulated rig as a separate program."""

import os
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import click

from daq.command_options import FILE, HIDDEN, SEED, SIM, DriveOptions, say_next_recording
from daq.cycle.stopping import SIGNALS
from daq.hidden_seed import HiddenSeed
from recordings.command_line import NameChoice


@click.command(
    name="sim",
    short_help="Run the simulated rig on its own.",
    epilog="Example: daq sim --rig bench.toml --seed 1",
)
@click.option("--rig", "rig_file", type=FILE, required=True, help="Rig file with the bus to serve.")
@click.option("--pace", type=NameChoice(["lockstep", "realtime"]), default="realtime", show_default=True)
@SEED
@SIM
@click.option(
    "--eds", type=FILE, multiple=True, help="EDS or DCF of the drives on a CAN bus: one for all, or one per joint."
)
@click.option(
    "--habit",
    "habits",
    multiple=True,
    metavar="KEY=VALUE",
    help="Habit of the drives that an EDS does not tell, e.g. fault_reset=0.1; see the sim file.",
)
@HIDDEN
@click.option(
    "--until-eof", is_flag=True, help="End when the standard input ends: with the program that started this."
)
@click.option("--truth", type=FILE, default=Path("sim.sealed.json"), show_default=True, help="Their sealed truth.")
def command(
    rig_file: Path,
    pace: str,
    seed: int,
    sim_file: Path | None,
    eds: tuple[Path, ...],
    habits: tuple[str, ...],
    hidden: HiddenSeed | None,
    until_eof: bool,
    truth: Path,
) -> None:
    """Serve three simulated drives around a simulated robot, until SIGINT, SIGTERM or SIGHUP.

    The rig file names the bus: `udp_multicast` reaches other programs on this machine, `socketcan` a real or virtual
    CAN interface; serial ports are links to pseudo-terminals, made here and removed at the end. Record from another
    terminal with `daq record --rig` and the same file.

    With --eds the drives have the object dictionary of that EDS or DCF: its objects, limits, units and default PDOs.
    """
    from daq.simulation import configured, simulated
    from drivers import transports
    from drivers.simulated import transports as simulations
    from recordings.errors import BadInput
    from recordings.rig import load_rig

    rig = load_rig(rig_file)
    if transports.of(rig).simulated_here(rig):
        raise BadInput(
            "a bus that other programs can reach expected, one that ends at this program found; set bus.interface to "
            "udp_multicast or socketcan, or bus.ports to names in the file system"
        )
    simulations.of(rig).check_not_in_use(rig)
    config = configured(rig, sim_file, hidden, truth, eds, habits)
    machine = simulated(rig, config, "lockstep" if pace == "lockstep" else "realtime", seed)
    for number in SIGNALS:
        signal.signal(number, lambda *_: machine.stop())
    if until_eof:
        threading.Thread(target=_wait_for_eof, args=(machine.stop,), daemon=True).start()
    nodes = ", ".join(drive.address for drive in rig.drives)
    click.echo(f"simulated drives ({nodes}) on {simulations.of(rig).place(rig)}, {pace}; Ctrl-C ends")
    say_next_recording(rig, DriveOptions(rig_file, pace="lockstep" if pace == "lockstep" else None))
    try:
        machine.run()
    finally:
        machine.close()


def _wait_for_eof(stop: Callable[[], None]) -> None:
    # Not by the buffered reader, whose lock a thread that waits would hold when the program ends.
    while os.read(sys.stdin.fileno(), 4096):
        pass
    stop()
