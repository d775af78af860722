"""A recording, from the check of its request to the figures that are printed: on the drives, dry, or by listening."""

import json
import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

import click
from rich.console import Console

from daq.bench import Bench
from daq.cycle.progress import CycleProgress
from daq.cycle.session import Display, RunRequest, Session, check_request
from daq.feedforward.planning import ASSUMED_GAIN
from daq.feedforward.source import open_source
from daq.live.status import LineSink, StatusLines, to_stdout
from daq.live.terminal import ProgressBar, figures, heard_summary, summary
from daq.live.viewers import viewers
from daq.passive import listen
from daq.passive.reconstruct import Motion
from daq.watch import RunWatch
from drivers import transports
from recordings.command_line import output_name, say, say_next, say_report
from recordings.errors import BadInput
from recordings.limits import json_object
from recordings.progress import progress_bar
from recordings.rig import Rig
from trajectories import Trajectory
from trajectories.checks import check


def record(
    bench: Bench,
    trajectory: Trajectory,
    out: Path | None,
    analysis: str = "fit",
    *,
    as_json: bool,
    dry_run: bool = False,
    feedforward: Path | None = None,
    rig_file: Path | None = None,
    status: bool = False,
    page: bool = False,
    foxglove: int | None = None,
    watch: Path | None = None,
    stop_on_alarm: bool = False,
) -> None:
    """Record a trajectory, or do all of it but power and file (`dry_run`), and print its figures.

    Args:
        out: the recording; None: named after the trajectory.
        analysis: command of `ident` that comes next.
        feedforward: model or table of the torque that is fed forward; `rig_file`: of the rig, for the model.
        status: JSON lines on stdout while the run goes on.
        page, foxglove: the viewers, and the port of the latter.
        watch: model that goes along; stop_on_alarm: its alarm stops the motion.

    Raises:
        BadInput: the trajectory exceeds a limit, the file exists, or rig, sim file or feed-forward do not suit.
        RunFailed: the motion was not completed.
        StoppedByAlarm: it was stopped by the alarm.
    """
    if stop_on_alarm and watch is None:
        raise BadInput("--stop-on-alarm belongs to --watch; drop it, or give a model")
    if watch is not None:
        json_object(watch, "--watch: a model file")
    if ASSUMED_GAIN in bench.accepted and feedforward is None:
        raise BadInput(f"--accept {ASSUMED_GAIN} belongs to --feedforward; drop it")
    check(trajectory, bench.rig)
    out = output_name(out, Path(f"{trajectory.name}.mcap"))
    request = RunRequest(bench.rig, trajectory, out, bench.pace, bench.seed, accepted=bench.accepted)
    if feedforward is not None:
        rig = bench.rig.with_torque_offset()
        source = open_source(feedforward, rig, rig_file, trajectory)
        request = replace(request, rig=rig, feedforward=source)
        bench = replace(bench, rig=rig)
    check_request(request)
    with viewers(request, page, foxglove, say) as sinks, bench.serve(request.out):
        bench.announce(f"{trajectory.name}, {len(trajectory.repeat) / bench.rig.rate:.1f} s at {bench.rig.rate:g} Hz")
        say(transports.of(bench.rig).describe(bench.rig))
        sink = _one_at_a_time([*sinks, *([to_stdout] if status else [])])
        if watch is not None:
            request = replace(request, watch=RunWatch(watch, stop_on_alarm, sink))
        session = Session(request, say_report)
        if dry_run:
            _dry_run(session, request.rig, as_json)
        else:
            _run(session, request, status, sink, analysis, as_json)


def _one_at_a_time(sinks: Sequence[LineSink]) -> LineSink:
    """One sink for all `sinks`, which the threads of status and watch may use."""
    lock = threading.Lock()

    def send(line: str) -> None:
        with lock:
            for sink in sinks:
                sink(line)

    return send


def _run(session: Session, request: RunRequest, status: bool, sink: LineSink, analysis: str, as_json: bool) -> None:
    result = session.run(_display(request.rig.rate, not status, sink))
    simulated = any(identity.simulated for identity in result.identities)
    if as_json or status:
        document = {"schema": 1, "recording": str(request.out), "simulated": simulated, **figures(result)}
        click.echo(json.dumps(document))
        return
    console = Console(markup=False)
    console.print(summary(result))
    mark = " (simulated)" if simulated else ""
    no_torque = any(drive.torque_source == "none" for drive in request.rig.drives)
    following = ("daq", "info") if no_torque else ("ident", analysis)
    console.print(f"recorded {request.out}{mark}", style="bold", soft_wrap=True)
    say_next(*following, request.out)


def _display(rate: float, bar: bool, sink: LineSink) -> Display:
    @contextmanager
    def display(progress: CycleProgress) -> Iterator[None]:
        with ExitStack() as stack:
            if bar:
                stack.enter_context(ProgressBar(progress))
            stack.enter_context(StatusLines(progress, rate, sink))
            yield

    return display


def _dry_run(session: Session, rig: Rig, as_json: bool) -> None:
    result, position = session.dry_run(ProgressBar)
    if as_json:
        click.echo(json.dumps({"schema": 1, "dry_run": True, "joint_position": position, **figures(result)}))
        return
    console = Console(markup=False)
    console.print(summary(result))
    poses = (f"{here:.4f} {unit}" for here, unit in zip(position, rig.position_units, strict=True))
    console.print("joints stand at", ", ".join(poses))
    console.print("dry run: everything but power and file worked; nothing has moved", style="bold")


def record_heard(
    rig: Rig,
    motion: Motion | None,
    out: Path | None,
    duration: float | None,
    *,
    lockstep: bool = False,
    as_json: bool,
) -> None:
    """Record what another master makes the drives do, for `duration` [s] at most, and print what was found.

    lockstep: the drives are simulated in lockstep, and the times of the SYNCs tell nothing.

    Raises:
        BadInput: the bus cannot be listened to or opened, or the file exists.
        RunFailed: the bus is lost, or no SYNC was heard.
    """
    listen.check(rig)
    out = output_name(out, Path(f"{listen.TRAJECTORY_NAME}.mcap"))
    announced = False
    with progress_bar("listening") as show:

        def show_heard(heard: listen.FrameRecorder) -> None:
            nonlocal announced
            if not announced:
                # Only after the bus is open: another program may wait for this line before it starts.
                announced = True
                say(f"listening on {rig.can.interface} '{rig.can.channel}', sending nothing; Ctrl-C ends")
            show(f"listening: {heard.syncs} SYNCs, {heard.frames} frames")

        heard, reconstructed = listen.record(rig, out, motion, duration, show_heard, lockstep=lockstep)
    if motion is not None and reconstructed.trajectory is None:
        say(f"warning: the motion {motion(None).name} is not what was commanded; see what was found", "yellow")
    warnings = [*filter(None, (reconstructed.other_rate(), reconstructed.loss()))]
    for warning in warnings:
        say(f"warning: {warning}", "yellow")
    found = {"frames": heard.frames, "syncs": heard.syncs, **reconstructed.figures()}
    if as_json:
        click.echo(json.dumps({"schema": 1, "recording": str(out), **found}))
        return
    Console(markup=False).print(heard_summary(found))
    click.echo(f"recorded {out} (listened)")
    if not warnings:
        say_next("ident", "fit", out)
