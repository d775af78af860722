"""`daq record`: stream a motion and record what happened."""

from collections.abc import Mapping
from pathlib import Path

import click

from daq.command_options import FILE, HIDDEN, JSON, PACE, PAYLOAD, RATE, RIG, SEED, SIM, DriveOptions, drive_options
from recordings.command_line import FiniteRange, IntegerRange, NameChoice, refuse_together, say_next
from recordings.errors import BadInput


@click.command(
    name="record",
    short_help="Stream a motion to the drives and record it.",
    epilog="Example: daq record --traj fig5a --out run.mcap",
)
@click.option("--traj", "trajectory", help="Name (see `daq trajectories`) or file of the motion.")
@drive_options(
    RIG,
    RATE,
    PACE,
    SEED,
    SIM,
    HIDDEN,
    click.option(
        "--accept",
        multiple=True,
        type=NameChoice(["assumed-gain", "pose"]),
        help="Accept by name what is refused: an assumed gain with --feedforward on real drives, a pose "
        "that is whole motor turns from the last one.",
    ),
    PAYLOAD,
)
@click.option("--cycles", type=IntegerRange(1), help="Repetitions of the motion.  [default: about 20 s]")
@click.option("--out", type=FILE, help="Recording to write.  [default: TRAJ.mcap]")
@click.option(
    "--dry-run", is_flag=True, help="All but power and file: set up the drives, exchange cycles, move nothing."
)
@click.option(
    "--feedforward",
    type=FILE,
    metavar="MODEL|TABLE.csv",
    help="Send the model's torque along the motion with every target (60B2h).  [default: off]",
)
@click.option(
    "--watch", type=FILE, metavar="MODEL", help="Compare the robot with the model while it moves; needs `ident`."
)
@click.option("--stop-on-alarm", is_flag=True, help="Stop as Ctrl-C does when --watch raises an alarm; exit code 3.")
@click.option("--listen", is_flag=True, help="Send nothing: record what another master makes the drives do.")
@click.option("--duration", type=FiniteRange(0, min_open=True), metavar="S", help="How long to listen [s].")
@JSON
@click.option(
    "--status",
    is_flag=True,
    help="For a program that watches: the run as JSON lines on stdout while it goes on. It is stopped when nobody "
    "reads them any more.",
)
@click.option("--live", is_flag=True, help="Show the run in the browser of this machine while it goes on.")
@click.option(
    "--foxglove",
    type=IntegerRange(1, 65535),
    is_flag=False,
    flag_value=8765,
    metavar="[PORT]",
    help="Serve the run over the Foxglove WebSocket.  [port: 8765]",
)
def command(
    trajectory: str | None,
    drives: DriveOptions,
    cycles: int | None,
    out: Path | None,
    dry_run: bool,
    feedforward: Path | None,
    watch: Path | None,
    stop_on_alarm: bool,
    listen: bool,
    duration: float | None,
    as_json: bool,
    status: bool,
    live: bool,
    foxglove: int | None,
) -> None:
    """Stream a motion to the three drives over CANopen or serial lines; record every cycle and frame to an MCAP file.

    Without --rig, or with a rig on the `virtual` interface, three simulated drives around a simulated robot answer.
    Ctrl-C once ramps the motion down and disables the drives; Ctrl-C twice is a quick stop.

    With --feedforward the drives get the torque that the motion takes, and their loops add only what the model lacks.
    It begins and ends at 0, is limited and watched; see `docs/how-to/feed-forward.md`.

    With --watch the model goes along, and an alarm is an event of the recording; see `docs/how-to/watch-a-robot.md`.

    With --listen nothing is sent: it ends with Ctrl-C, after --duration, or five seconds after the last SYNC. --traj
    then names the motion that the other master runs, if it is known.
    """
    from daq.live.recording import record
    from trajectories import load

    _refuse_conflicts()
    if listen:
        _listen(drives, trajectory, cycles, out, duration, as_json)
        return
    if trajectory is None:
        raise click.UsageError("Missing option '--traj'.")
    if duration is not None:
        raise BadInput("--duration says how long to --listen; a motion lasts as long as its --cycles")
    bench = drives.bench()
    record(
        bench,
        load(trajectory, bench.rig, cycles),
        out,
        as_json=as_json,
        dry_run=dry_run,
        feedforward=feedforward,
        rig_file=drives.rig_file,
        status=status,
        page=live,
        foxglove=foxglove,
        watch=watch,
        stop_on_alarm=stop_on_alarm,
    )
    if dry_run:
        again = {"--cycles": cycles, "--out": out, "--feedforward": feedforward, "--watch": watch}
        _say_next(drives, trajectory, again)


def _say_next(drives: DriveOptions, trajectory: str, given: Mapping[str, object]) -> None:
    given = {"--rig": drives.rig_file, "--rate": drives.rate, **given}
    options = [word for name, value in given.items() if value is not None for word in (name, value)]
    say_next("daq", "record", "--traj", trajectory, *options)


def _listen(
    drives: DriveOptions,
    trajectory: str | None,
    cycles: int | None,
    out: Path | None,
    duration: float | None,
    as_json: bool,
) -> None:
    from daq.live.recording import record_heard
    from trajectories import Trajectory, load

    if drives.rig_file is None:
        raise BadInput("--listen needs --rig; say on which bus to listen")
    rig = drives.rig()

    def motion(found: int | None) -> Trajectory:
        return load(str(trajectory), rig, cycles or found)

    if trajectory is not None:
        motion(None)  # an unknown one is refused before anything is heard
    lockstep = drives.pace == "lockstep"
    record_heard(rig, motion if trajectory else None, out, duration, lockstep=lockstep, as_json=as_json)


def _refuse_conflicts() -> None:
    for option in ("--status", "--live", "--foxglove", "--watch"):
        refuse_together(option, "--listen", "--dry-run", because="it shows a motion")
    for option in ("--sim", "--hidden", "--feedforward", "--dry-run"):
        refuse_together("--listen", option, because="nothing is sent while listening; drop one of them")
    refuse_together("--status", "--json", because="the lines of --status end with the figures of --json")
    refuse_together("--dry-run", "--hidden", because="nothing is recorded to hide an effect in; drop --hidden")
