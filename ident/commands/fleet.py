"""`ident fleet`: many recordings of many robots over time, and what has changed since when."""

from __future__ import annotations

import json
import os
import re
import shlex
import sys
import time
from collections.abc import Callable, Sequence
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ident.basics import plugins
from ident.command_options import ALARM, CUTOFF, FILE, JSON, PLACE, PREPROCESS, print_result, say_written
from ident.fleet import check_installed
from recordings.command_line import Date, IntegerRange, NameChoice, refuse_existing, say, say_next
from recordings.errors import BadInput
from recordings.files import free_name

if TYPE_CHECKING:
    from ident.fleet.alarms import Alarm, FleetFile
    from ident.fleet.store import Store
    from ident.fleet.update import Plan
    from recordings.progress import Show


def _needed(context: click.Context, parameter: click.Parameter, value: Path | None) -> Path:
    """The store, which each of these commands needs; say how it is given."""
    if value is None:
        example = (context.command.epilog or "").rpartition("Example: ")[2]
        raise BadInput(f"--store DIR expected, the folder of the results, none found; say, {example}")
    return value


STORE = click.option(
    "--store", "folder", type=PLACE, callback=_needed, metavar="DIR", help="Folder of the results.  [required]"
)


class FolderOrCommand(click.Group):
    """A group whose first argument is a subcommand, or else the first argument of its first command."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """See click: without a command, the fleet is updated."""
        if not args or args[0] not in self.commands:
            args = [_UPDATE, *args]
        return super().parse_args(ctx, args)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """See click."""
        name, chosen, rest = super().resolve_command(ctx, args)
        return None if name == _UPDATE else name, chosen, rest

    def invoke(self, ctx: click.Context) -> Any:
        """See click; an object store may be lost at any time."""
        from ident.fleet.places import connected

        with connected():
            return super().invoke(ctx)


_UPDATE = "FOLDER"


@click.group(
    cls=FolderOrCommand,
    short_help="Watch many robots over time.",
    add_help_option=False,
    invoke_without_command=False,
)
def command() -> None:
    """Watch many robots over time."""


@command.command(
    _UPDATE,
    epilog="Subcommands: ident fleet report (a page), ident fleet ack (acknowledge alarms), ident fleet rebuild (the "
    "state of a store); a folder of such a name is ./report. Example: ident fleet recordings --store fleet",
)
@click.argument("folders", metavar="FOLDER...", nargs=-1, required=True, type=PLACE)
@STORE
@click.option(
    "--engine",
    type=NameChoice(plugins.names("ident.fleet.engines")),
    help="Where to compute.  [default: dask where it is installed or a scheduler is given, else processes; serial "
    "for a single recording or worker]",
)
@click.option("--workers", type=IntegerRange(1), metavar="N", help="Local workers.  [default: one per processor]")
@click.option("--scheduler", metavar="ADDRESS", help="Compute on a running Dask cluster, say tcp://host:8786.")
@click.option("--scheduler-file", type=FILE, metavar="FILE", help="The same, by the file that its scheduler wrote.")
@click.option(
    "--on-alarm", metavar="COMMAND", help="Start it once for each new alarm, with the alarm as JSON on stdin."
)
@PREPROCESS
@CUTOFF
@JSON
def update_command(
    folders: tuple[Path, ...],
    folder: Path,
    engine: str | None,
    workers: int | None,
    scheduler: str | None,
    scheduler_file: Path | None,
    on_alarm: str | None,
    preprocess: str,
    cutoff: float | None,
    as_json: bool,
) -> None:
    """Analyse what is new in the FOLDERs of recordings, and say which robot has changed, how, and since when.

    Every recording becomes rows in the store, a table in Parquet files. What was analysed before is not analysed
    again. A recording that cannot be used is a row with the reason. Exit code 3: done, alarms are open.

    FOLDER and DIR may be in an object store, as s3://bucket/folder or gs://bucket/folder.
    """
    check_installed()

    from ident.fleet import alarms, engines
    from ident.fleet.engines import EngineOptions
    from ident.fleet.places import in_object_store
    from ident.fleet.settings import FleetSettings
    from ident.fleet.store import Store
    from ident.fleet.update import plan, update
    from ident.fleet.walk import check_folders
    from recordings.progress import progress_bar

    check_folders(folders)
    _check_scheduler(scheduler, scheduler_file)
    store, settings = Store(folder), FleetSettings(preprocess, cutoff)
    workers = workers or os.cpu_count() or 1
    with store.locked(), progress_bar("looking for recordings") as show:
        work = plan(store, folders, settings)
        _say_what_is_done(work)
        chosen = _engine(engine, workers, scheduler or scheduler_file, len(work.pending))
        options = EngineOptions(workers, scheduler, scheduler_file, say)
        count = update(store, work, settings, chosen, options, _rated(show, "analysing"))
        result = alarms.find(
            store,
            settings,
            folders,
            {"seen": count.seen, "new": count.new, "failed": count.failed},
            lambda done, total: show("diagnosing events", done, total),
            partial(engines.load(chosen).run, options=options),
        )
        new_alarms = alarms.unheard(store, result.alarms)
        alarms.save(store, result)
    for path, reason in count.unused:
        say(f"not used: {reason if path in reason else f'{path}: {reason}'}", "yellow")
    _show(result, as_json)
    if on_alarm:
        _pass_on(on_alarm, new_alarms)
    page = (Path(folder.name) if in_object_store(folder) else folder).with_suffix(".html")
    say_next("ident", "fleet", "report", "--store", folder, "-o", free_name(page))
    if any(not alarm.acknowledged for alarm in result.alarms):
        sys.exit(ALARM)


@command.command(
    "report",
    short_help="Write a page of a fleet.",
    epilog="Example: ident fleet report --store fleet -o fleet.html",
)
@STORE
@click.option("-o", "--out", type=FILE, required=True, metavar="FILE", help="Page to write (.html).")
@click.option("--force", is_flag=True, help="Replace an existing page.")
def report_command(folder: Path, out: Path, force: bool) -> None:
    """Write a self-contained page: the fleet at a glance, alarms with their evidence, and every robot over time."""
    store = _opened(folder)
    refuse_existing(out, force=force)

    from ident.fleet import alarms, page
    from recordings.progress import progress_bar

    content = alarms.load(store)
    with progress_bar("drawing"):
        page.write(store, content, out)
    say_written(report=out)
    opened = [alarm.id for alarm in content.alarms if not alarm.acknowledged]
    if opened:
        say_next("ident", "fleet", "ack", *opened, "--store", folder)


@command.command(
    "ack",
    short_help="Acknowledge alarms.",
    epilog="Example: ident fleet ack r07-20260314 --store fleet --note 'gear replaced'",
)
@click.argument("words", metavar="ALARM... | ROBOT EFFECT", nargs=-1, required=True)
@STORE
@click.option("--note", default="", metavar="TEXT", help="What is known of it.")
@click.option(
    "--repaired",
    type=Date(),
    metavar="DATE",
    help="The robot was repaired: its nights since that date (UTC) are a new baseline.",
)
@click.option("--undo", is_flag=True, help="Open them again, and forget the repair.")
@click.option("--json", "as_json", is_flag=True, help="Print all alarms as one JSON document.")
def ack_command(
    words: tuple[str, ...], folder: Path, note: str, repaired: datetime | None, undo: bool, as_json: bool
) -> None:
    """Acknowledge alarms, which then no longer are open; they stay in the report with the note.

    They are named by their ids, or by a robot and the effect that it shows (unknown-structure, where none is named).
    """
    store = _opened(folder)

    from ident.fleet import alarms

    with store.locked():
        alarms.acknowledge(store, words, note, undo, repaired.date() if repaired else None)
    content = alarms.load(store)
    _show(content, as_json)


@command.command(
    "rebuild",
    short_help="Make anew what follows from the rows of a store.",
    epilog="Example: ident fleet rebuild --store fleet",
)
@STORE
def rebuild_command(folder: Path) -> None:
    """Make anew what follows from the rows of a store: what each robot has shown so far.

    It is needed where files of the store were removed or came from a copy; a run does so itself for a robot whose
    state is damaged, or one of whose recordings came late.
    """
    store = _opened(folder)

    from ident.fleet import alarms, follow
    from recordings.progress import progress_bar

    content = alarms.load(store)
    with store.locked(), progress_bar("gathering evidence anew"):
        follow.rebuild(store, content.settings)
    say_next("ident", "fleet", *content.folders, "--store", folder)


def _opened(folder: Path) -> Store:
    if not folder.is_dir():
        raise BadInput(f"{folder}: a store of `ident fleet` expected, none found; check the path")
    check_installed()
    from ident.fleet.store import Store

    return Store(folder)


def _say_what_is_done(work: Plan) -> None:
    if work.outdated:
        say(f"{work.outdated} recordings were analysed with other settings or an earlier version; they are redone")
    if not work.seen:
        say("no recordings (.mcap) below these folders", "yellow")


def _pass_on(command: str, new: Sequence[Alarm]) -> None:
    """Start the `command` for each of the alarms; one that fails keeps none of the others back."""
    import subprocess

    for alarm in new:
        text = json.dumps(alarm.model_dump(mode="json"))
        try:
            subprocess.run(shlex.split(command), input=text, text=True, check=True)
        except (OSError, ValueError, subprocess.CalledProcessError) as error:
            say(f"--on-alarm: the command expected to take {alarm.id}, it failed: {error}; tell it yourself", "red")


def _check_scheduler(address: str | None, file: Path | None) -> None:
    if address is not None and not re.fullmatch(r"(\w+://)?.+:\d+", address):
        raise BadInput(f"--scheduler: an address as tcp://host:8786 expected, '{address}' found; correct it")
    if file is not None and not file.is_file():
        raise BadInput(f"--scheduler-file {file}: a file that a Dask scheduler wrote expected, none found; check it")


def _engine(name: str | None, workers: int, scheduler: object, pending: int) -> str:
    if scheduler and name not in (None, "dask"):
        raise BadInput(f"--engine dask expected beside a scheduler, '{name}' found; leave one out")
    if name or scheduler:
        return name or "dask"
    if pending <= 1 or workers == 1:
        return "serial"
    from importlib.util import find_spec

    return "dask" if find_spec("distributed") else "processes"


def _rated(show: Show, activity: str) -> Callable[[int, int], None]:
    """Show progress with its rate and the time that remains."""
    begin = time.monotonic()

    def progress(done: int, total: int) -> None:
        rate = done / max(time.monotonic() - begin, 1e-9)
        remaining = (total - done) / rate
        show(f"{activity} {done}/{total}, {rate:.1f}/s, {remaining / 60:.0f} min left", done, total)

    return progress


def _show(result: FleetFile, as_json: bool) -> None:
    if as_json:
        document = result.model_dump(mode="json", by_alias=True)
        print_result({name: document[name] for name in ("schema", "recordings", "alarms")})
        return
    counts = result.recordings
    click.echo(f"{counts['seen']} recordings, {counts['new']} of them new; {counts['failed']} cannot be used")
    for alarm in result.alarms:
        click.echo(_line(alarm))
    if not result.alarms:
        click.echo("no alarms")


def _line(alarm: Alarm) -> str:
    joints = f"joint {', '.join(map(str, alarm.joints))}" if alarm.joints else "the whole robot"
    what = alarm.effect or f"unknown, depends on {', '.join(alarm.depends_on) or 'nothing known'}"
    if alarm.confusable_with:
        what += f" (or {', '.join(alarm.confusable_with)})"
    first, last = alarm.since_ci95
    since = alarm.since if first == last else f"{alarm.since} ({first} to {last})"
    state = ", acknowledged" if alarm.acknowledged else ""
    return f"{alarm.id}: {what} on {joints}, {alarm.kind}, since {since}{state}"
