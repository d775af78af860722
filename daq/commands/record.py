"""`daq record`: stream a motion and record what happened."""

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from daq.command_options import PACE, RATE, RIG, SEED
from recordings.command_line import FiniteRange, say, say_next

if TYPE_CHECKING:
    from daq.cycle.session import Display, Result, RunRequest
    from daq.live.status import LineSink
    from recordings.rig import Rig
    from trajectories import Trajectory

_FILE = click.Path(path_type=Path)


@click.command(
    name="record",
    short_help="Stream a motion to the drives and record it.",
    epilog="Example: daq record --traj fig5a --out run.mcap",
)
@click.option("--traj", "trajectory", help="Name (see `daq trajectories`) or file of the motion.")
@RIG
@click.option("--cycles", type=click.IntRange(1), help="Repetitions of the motion.  [default: about 20 s]")
@RATE
@click.option("--out", type=_FILE, help="Recording to write.  [default: TRAJ.mcap]")
@PACE
@SEED
@click.option(
    "--sim",
    "sim_file",
    type=_FILE,
    help="What the simulated machine really is: a sim file (TOML), or a shipped robot: heavy, light, paper_friction.",
)
@click.option("--hidden", type=click.IntRange(0), help="Hide effects drawn from this seed in the simulated machine.")
@click.option(
    "--dry-run", is_flag=True, help="All but power and file: set up the drives, exchange cycles, move nothing."
)
@click.option(
    "--feedforward",
    type=_FILE,
    metavar="MODEL|TABLE.csv",
    help="Send the model's torque along the motion with every target (60B2h).  [default: off]",
)
@click.option(
    "--accept",
    multiple=True,
    type=click.Choice(["assumed-gain"]),
    help="Accept by name what --feedforward refuses on real drives.",
)
@click.option("--listen", is_flag=True, help="Send nothing: record what another master makes the drives do.")
@click.option("--duration", type=FiniteRange(0, min_open=True), metavar="S", help="How long to listen [s].")
@click.option("--json", "as_json", is_flag=True, help="Figures as JSON on stdout.")
@click.option(
    "--status",
    is_flag=True,
    help="For a program that watches: the run as JSON lines on stdout while it goes on. It is stopped when nobody "
    "reads them any more.",
)
@click.option("--live", is_flag=True, help="Show the run in the browser of this machine while it goes on.")
@click.option(
    "--foxglove",
    type=click.IntRange(1, 65535),
    is_flag=False,
    flag_value=8765,
    metavar="[PORT]",
    help="Serve the run over the Foxglove WebSocket.  [port: 8765]",
)
def command(
    trajectory: str | None,
    rig_file: Path | None,
    cycles: int | None,
    rate: float | None,
    out: Path | None,
    pace: str | None,
    seed: int,
    sim_file: Path | None,
    hidden: int | None,
    dry_run: bool,
    feedforward: Path | None,
    accept: tuple[str, ...],
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

    With --listen nothing is sent: it ends with Ctrl-C, after --duration, or five seconds after the last SYNC. --traj
    then names the motion that the other master runs, if it is known.
    """
    from daq.cycle.session import check_request, rig_from
    from daq.live.viewers import viewers
    from drivers import transports
    from recordings.errors import BadInput
    from trajectories import load

    rig = rig_from(rig_file, rate)
    if (status or live or foxglove) and (listen or dry_run):
        raise BadInput("--status, --live and --foxglove show a motion; drop --listen and --dry-run")
    if status and as_json:
        raise BadInput("--status ends with the figures of --json; drop one of them")
    if listen:
        if rig_file is None or pace or sim_file or hidden is not None or dry_run or feedforward:
            raise BadInput("--listen needs --rig, and no --pace, --sim, --hidden, --feedforward or --dry-run")
        _listen(rig, trajectory, cycles, out, duration, as_json)
        return
    if trajectory is None:
        raise click.UsageError("Missing option '--traj'.")
    if duration is not None:
        raise BadInput("--duration says how long to --listen; a motion lasts as long as its --cycles")
    simulated = transports.of(rig).simulated_here(rig)
    if not simulated and (sim_file or hidden is not None):
        raise BadInput("--sim and --hidden are for the simulated rig inside `daq record`; give them to `daq sim`")
    if dry_run and hidden is not None:
        raise BadInput("--dry-run records nothing, so there is nothing to hide an effect in; drop --hidden")
    request = _request(rig, load(trajectory, rig, cycles), out, pace, seed, simulated)
    request = _with_feedforward(request, feedforward, rig_file, accept)
    check_request(request)
    with viewers(request, live, foxglove, say) as sinks:
        _run_on_drives(
            request,
            sim_file,
            hidden,
            lambda: _dry_run(request, as_json) if dry_run else _record(request, as_json, status, sinks),
        )
    if dry_run:
        given = {"--rig": rig_file, "--cycles": cycles, "--rate": rate, "--out": out, "--feedforward": feedforward}
        options = [word for name, value in given.items() if value is not None for word in (name, value)]
        say_next("daq", "record", "--traj", trajectory, *options)


def record_trajectory(
    rig: "Rig",
    trajectory: "Trajectory",
    out: Path | None,
    pace: str | None,
    seed: int,
    sim_file: Path | None,
    as_json: bool,
    analysis: str,
) -> None:
    """Record a trajectory on the drives of `rig`, or on the simulated rig, as the command does.

    analysis: command of `ident` that comes next.

    Raises:
        BadInput: the trajectory exceeds a limit, the file exists, or the rig or sim file does not suit.
        RunFailed: the motion was not completed.
    """
    from daq.cycle.session import check_request
    from drivers import transports
    from recordings.errors import BadInput

    simulated = transports.of(rig).simulated_here(rig)
    if sim_file and not simulated:
        raise BadInput("--sim is for drives simulated inside this program; give it to `daq sim`")
    request = _request(rig, trajectory, out, pace, seed, simulated)
    check_request(request)
    _run_on_drives(request, sim_file, None, lambda: _record(request, as_json, False, [], analysis))


def _request(
    rig: "Rig", trajectory: "Trajectory", out: Path | None, pace: str | None, seed: int, simulated: bool
) -> "RunRequest":
    from daq.cycle.session import RunRequest
    from trajectories.checks import check

    check(trajectory, rig)
    return RunRequest(
        rig=rig,
        trajectory=trajectory,
        out=out or Path(f"{trajectory.name}.mcap"),
        pace="lockstep" if pace == "lockstep" or (pace is None and simulated) else "realtime",
        seed=seed if simulated else None,
    )


def _with_feedforward(
    request: "RunRequest", path: Path | None, rig_file: Path | None, accepted: tuple[str, ...]
) -> "RunRequest":
    from dataclasses import replace

    from daq.feedforward.source import open_source
    from recordings.errors import BadInput

    if path is None:
        if accepted:
            raise BadInput("--accept belongs to --feedforward; drop it")
        return request
    rig = request.rig.with_torque_offset()
    source = open_source(path, rig, rig_file, request.trajectory)
    return replace(request, rig=rig, feedforward=source, accepted=frozenset(accepted))


def _run_on_drives(request: "RunRequest", sim_file: Path | None, hidden: int | None, run: Callable[[], None]) -> None:
    """Call `run`, with the simulated rig running beside it if the drives are simulated."""
    from daq.simulation import configured, simulated
    from drivers.simulated.seal import sealed_path
    from recordings.errors import RunFailed

    if request.seed is None:
        run()
        return
    say("SIMULATED RIG: no real drive is connected; what is recorded comes from a simulated robot.", "yellow")
    config = configured(request.rig, sim_file, hidden, sealed_path(request.out))
    with simulated(request.rig, config, request.pace, request.seed) as machine:
        try:
            run()
        except RunFailed as error:
            if machine.error is None:
                raise
            raise RunFailed(f"{error}; the simulated rig itself stopped: {machine.error!r}") from machine.error


def _listen(
    rig: "Rig", name: str | None, cycles: int | None, out: Path | None, duration: float | None, as_json: bool
) -> None:
    from daq.passive.listen import TRAJECTORY_NAME, BusTraffic, check, record
    from recordings.progress import progress_bar
    from trajectories import load

    check(rig)
    trajectory = None if name is None else load(name, rig, cycles)
    out = out or Path(f"{TRAJECTORY_NAME}.mcap")
    announced = False
    with progress_bar("listening") as show:

        def show_traffic(traffic: BusTraffic) -> None:
            nonlocal announced
            if not announced:
                # Only after the bus is open: another program may wait for this line before it starts.
                announced = True
                say(f"listening on {rig.can.interface} '{rig.can.channel}', sending nothing; Ctrl-C ends")
            show(f"listening: {traffic.syncs} SYNCs, {traffic.frames} frames")

        traffic, reconstructed = record(rig, out, trajectory, duration, show_traffic)
    if trajectory is not None and reconstructed.trajectory is None:
        say(f"warning: the motion {trajectory.name} is not what was commanded; see what was found", "yellow")
    figures = {"frames": traffic.frames, "syncs": traffic.syncs, **reconstructed.figures()}
    if as_json:
        click.echo(json.dumps({"schema": 1, "recording": str(out), **figures}))
        return
    for label, value in figures.items():
        click.echo(f"{label.replace('_', ' ')}: {value}")
    click.echo(f"recorded {out} (listened); next: ident fit {out}")


def _record(
    request: "RunRequest", as_json: bool, status: bool, sinks: "list[LineSink]", analysis: str = "fit"
) -> None:
    from daq.cycle.session import Session
    from daq.live.status import to_stdout

    _announce(request)
    display = _display(request.rig.rate, not status, [*sinks, to_stdout] if status else sinks)
    _show(request, Session(request, _log).run(display), as_json or status, analysis)


def _display(rate: float, bar: bool, sinks: "Sequence[LineSink]") -> "Display":
    from daq.cycle.progress import CycleProgress
    from daq.live.status import StatusLines
    from daq.live.terminal import ProgressBar

    @contextmanager
    def display(progress: CycleProgress) -> Iterator[None]:
        with ExitStack() as stack:
            if bar:
                stack.enter_context(ProgressBar(progress))
            if sinks:
                stack.enter_context(StatusLines(progress, rate, sinks))
            yield

    return display


def _dry_run(request: "RunRequest", as_json: bool) -> None:
    from rich.console import Console

    from daq.cycle.session import Session
    from daq.live.terminal import ProgressBar, figures, summary

    _announce(request)
    result, position = Session(request, _log).dry_run(ProgressBar)
    if as_json:
        click.echo(json.dumps({"schema": 1, "dry_run": True, "joint_position": position, **figures(result)}))
        return
    console = Console()
    console.print(summary(result))
    console.print("joints stand at", ", ".join(f"{angle:.4f}" for angle in position), "rad")
    console.print("dry run: everything but power and file worked; nothing has moved", style="bold")


def _announce(request: "RunRequest") -> None:
    from drivers import transports

    duration = len(request.trajectory.repeat) / request.rig.rate
    say(f"{request.rig.name}: {request.trajectory.name}, {duration:.1f} s at {request.rig.rate:g} Hz, {request.pace}")
    say(transports.of(request.rig).describe(request.rig))


def _show(request: "RunRequest", result: "Result", as_json: bool, analysis: str) -> None:
    from rich.console import Console

    from daq.live.terminal import figures, summary

    simulated = any(identity.simulated for identity in result.identities)
    if as_json:
        click.echo(
            json.dumps({"schema": 1, "recording": str(request.out), "simulated": simulated, **figures(result)})
        )
        return
    console = Console()
    console.print(summary(result))
    console.print(
        f"recorded {request.out}{' (simulated)' if simulated else ''}; next: ident {analysis} {request.out}",
        style="bold",
    )


def _log(level: str, source: str, message: str) -> None:
    say(f"{level}: {source}: {message}", {"warning": "yellow", "error": "red"}.get(level))
