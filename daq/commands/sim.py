"""`daq sim`: simulated rig as a separate program."""

import signal
from pathlib import Path

import click

from daq.command_options import FILE, HIDDEN, SEED, SIM
from recordings.command_line import say_next


@click.command(
    name="sim",
    short_help="Run the simulated rig on its own.",
    epilog="Example: daq sim --rig bench.toml --seed 1",
)
@click.option("--rig", "rig_file", type=FILE, required=True, help="Rig file with the bus to serve.")
@click.option("--pace", type=click.Choice(["lockstep", "realtime"]), default="realtime", show_default=True)
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
@click.option("--truth", type=FILE, default=Path("sim.sealed.json"), show_default=True, help="Their sealed truth.")
def command(
    rig_file: Path,
    pace: str,
    seed: int,
    sim_file: Path | None,
    eds: tuple[Path, ...],
    habits: tuple[str, ...],
    hidden: int | None,
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
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: machine.stop())
    nodes = ", ".join(str(drive.node_id) for drive in rig.drives)
    click.echo(f"simulated drives (nodes {nodes}) on {simulations.of(rig).place(rig)}, {pace}; Ctrl-C ends")
    say_next("daq", "record", "--traj", "fig5a", "--rig", rig_file)
    try:
        machine.run()
    finally:
        machine.close()
