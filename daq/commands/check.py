"""`daq check`: compare the drives and the bus with the rig file without moving anything."""

import json
from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

import click

from daq.command_options import JSON, RATE, RIG, SIM, DriveOptions, drive_options
from recordings.command_line import FiniteRange, say_next
from recordings.drives import PROTECTIONS
from recordings.errors import BadInput, RunFailed

_ALWAYS_SHOWN = ("joint angle", "absolute zero", *PROTECTIONS)
"""What is shown where it is fine, too: where the joints stand, and what protects them."""

if TYPE_CHECKING:
    from drivers.protocol import Amplifiers, CheckResult, Identity


@click.command(
    name="check",
    short_help="Compare drives and bus with the rig file, move nothing.",
    epilog="Example: daq check --rig bench.toml",
)
@drive_options(RIG, RATE, SIM)
@click.option(
    "--set-up", "set_up", is_flag=True, help="Then write the set-up, without power: are all values accepted?"
)
@click.option(
    "--self-test",
    "tested",
    type=FiniteRange(0, 600, min_open=True),
    is_flag=False,
    flag_value=10.0,
    metavar="[S]",
    help="Then run the cycle with the drives set up and without power: time stamps, load, jitter.  [seconds: 10]",
)
@click.option("--all", "show_all", is_flag=True, help="Show what is fine, too.")
@JSON
def command(drives: DriveOptions, set_up: bool, tested: float | None, show_all: bool, as_json: bool) -> None:
    """Find the drives, compare state, units, limits, watchdogs and PDO maps with the rig file, compute the bus load.

    Nothing moves, and nothing is written unless --set-up or --self-test asks for it: which values a drive refuses is
    known only when they are written. Exit code 1 where a problem was found that would end a recording.
    """
    from daq.cycle.pose_memory import PoseMemory
    from drivers import transports
    from drivers.protocol import unheard

    bench = drives.bench()
    transport = transports.of(bench.rig)
    transport.check(bench.rig)
    with bench.serve(), closing(transport.connect(bench.rig, unheard, unheard, None)) as connected:
        identities = connected.discover()
        findings = [*connected.check(), *PoseMemory(bench.rig, identities).results()]
        if (set_up or tested is not None) and not _problems(findings):
            findings = _set_up(connected, findings)
        if tested is not None and not _problems(findings):
            findings += _self_test(connected, tested)
    problems = _problems(findings)
    bus = transport.describe(bench.rig)
    if as_json:
        document = {"schema": 1, "bus": bus, "drives": list(map(asdict, identities))}
        click.echo(json.dumps(document | {"findings": list(map(asdict, findings))}, indent=1))
    else:
        # What must be done stands first.
        ordered = problems + [finding for finding in findings if finding.verdict != "problem"]
        shown = [f for f in ordered if show_all or f.verdict != "fine" or f.what in _ALWAYS_SHOWN]
        _print_tables(bus, identities, shown)
    unproven = [finding for finding in findings if finding.verdict == "will be written"]
    if not problems:
        following = ("check", "--set-up") if unproven else ("jog", "--joint", 1, "--by", 0.05)
        say_next("daq", *following, *drives.words)
    if problems:
        raise RunFailed(f"{len(problems)} problem(s) found; correct the rig file or the drive")


def _self_test(amplifiers: "Amplifiers", duration: float) -> "Sequence[CheckResult]":
    from daq.cycle.realtime import realtime_priority
    from drivers.canopen.drive import CanopenDrives
    from drivers.protocol import unheard

    if not isinstance(amplifiers, CanopenDrives):
        raise BadInput("--self-test tests a CAN adapter, serial lines found; leave it out")
    with realtime_priority(unheard):
        return amplifiers.self_test(duration)


def _set_up(amplifiers: "Amplifiers", findings: "Sequence[CheckResult]") -> "list[CheckResult]":
    """Write the set-up as a recording does; `findings` after it, with what a drive refuses as a problem."""
    from drivers.protocol import CheckResult

    where, found = "drives", "written and read back"
    try:
        amplifiers.configure()
    except (BadInput, RunFailed) as error:
        drive, _, refused = str(error).partition(" refuses ")
        where, found = (drive, f"refuses {refused}") if refused else (where, str(error))
        return [*findings, CheckResult(where, "set-up", "every value accepted", found, "problem")]
    written = [
        replace(f, found=f.expected, verdict="fine") if f.verdict == "will be written" else f for f in findings
    ]
    return [*written, CheckResult(where, "set-up", "every value accepted", found, "noted")]


def _problems(findings: "Sequence[CheckResult]") -> "list[CheckResult]":
    return [finding for finding in findings if finding.verdict == "problem"]


def _print_tables(bus: str, identities: "Sequence[Identity]", findings: "Sequence[CheckResult]") -> None:
    from rich.console import Console
    from rich.table import Column, Table

    console = Console(markup=False)
    console.print(bus)
    for identity in identities:
        revision = "not told" if identity.revision is None else identity.revision
        console.print(f"joint {identity.joint}: {identity.address}, {identity.device}, revision {revision}")
    if not findings:
        console.print("all as the rig file says")
        return
    heads = ("where", "what", "rig file", "drive", "verdict")
    table = Table(*(Column(head, overflow="fold") for head in heads), box=None)
    colours = {"problem": "red", "accepted": "magenta", "will be written": "yellow"}
    # Drives of one type usually differ in the same way.
    groups: dict[tuple[str, ...], list[str]] = {}
    for finding in findings:
        row = (finding.what, finding.expected, finding.found, finding.verdict)
        groups.setdefault(row, []).append(finding.where)
    for values, places in groups.items():
        table.add_row(_shortened(places), *values, style=colours.get(values[-1]))
    console.print(table)
    console.print(_promise(findings))


def _promise(findings: "Sequence[CheckResult]") -> str:
    """What the comparison leaves open."""
    if any(finding.what == "set-up" for finding in findings):
        return "What differs is written and read back at the start of a recording."
    differing = dict.fromkeys(f.what.split()[0] for f in findings if f.verdict == "will be written")
    names = [name for name in differing if name[4:5] == ":" and not "1400" <= name < "1C00"]
    return (
        "What differs is written and read back at the start of a recording. A drive tells its limits only when it is "
        f"written to: --set-up tries {', '.join([*names, 'the PDOs'])}, without power."
    )


def _shortened(places: "Sequence[str]") -> str:
    if len(places) > 1 and all(place.startswith("joint ") for place in places):
        return "joints " + ", ".join(place.split()[1] for place in places)
    return ", ".join(places)
