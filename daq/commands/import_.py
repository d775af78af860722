"""`daq import`: conversion of measurements of another program to a recording."""

import json
import math
import shlex
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from recordings.importing import Choice, Description, Imported
    from recordings.importing.observations import Observation

_FILE = click.Path(path_type=Path)
_DESCRIBING = frozenset(
    (
        "--rig",
        "--mechanism",
        "--joints",
        "--torque-map",
        "--gain",
        "--kt",
        "--gravity",
        "--start",
        "--robot",
        "--simulated",
    )
)
"""Options that a proposed command repeats."""
_EPILOG = """\b
Examples:
  daq import bench.csv --out bench.mcap --rig rig.toml
  daq import scope.csv --guess
  daq import scope.csv --out scope.mcap --map "time=t:ms" --map "position_1=q1:deg" --map "current_1=i1:A" --kt 0.12
  daq import rosbag2_2026_01_05/ --out bag.mcap --topic /joint_states --names left,right,rear
  daq import axis.csv --out axis.mcap --mechanism axes --joints prismatic --torque-map linear --gain 12.5"""


@click.command(short_help="Turn measurements of another program into a recording.", epilog=_EPILOG)
@click.argument("file", metavar="DATA", type=_FILE)
@click.option("--out", type=_FILE, help="Recording to write (.mcap).")
@click.option(
    "--guess", "only_guess", is_flag=True, help="Say what each column may be, and the command; write nothing."
)
@click.option(
    "--map",
    "mapping",
    multiple=True,
    metavar="NAME=COLUMN:UNIT",
    help="A column and its unit; or a TOML file of such.",
)
@click.option("--topic", help="ROS bag: topic of joint states.  [default: the only one]")
@click.option("--names", metavar="A,B,...", help="ROS bag: names of the joints, in the order of their numbers.")
@click.option("--rig", "rig_file", type=_FILE, help="Rig file (TOML) that says what was measured.")
@click.option(
    "--mechanism", type=click.Choice(["delta", "axes"]), help="Without a rig file.  [default: delta for 3 joints]"
)
@click.option(
    "--joints", metavar="KIND,...", help="revolute or prismatic, for all axes or one each.  [default: revolute]"
)
@click.option("--torque-map", type=click.Choice(["square", "linear"]), help="Torque = gain v|v|, or gain v.")
@click.option(
    "--gain", metavar="NUMBER,...", help="N m/V^2 or N m/V (N for prismatic joints), for all joints or one each."
)
@click.option(
    "--kt", metavar="NUMBER,...", help="N m/A (N/A for prismatic joints) of current_i, for all joints or one each."
)
@click.option("--gravity", is_flag=True, help="Gravity loads the joint; of --mechanism axes with a single axis.")
@click.option("--start", metavar="DATE", help="Time of the first sample, such as 2026-01-05T08:00:00Z.")
@click.option("--robot", metavar="NAME", help="Name of the robot, kept in the recording.")
@click.option("--simulated", is_flag=True, help="The measurements come from a simulation; the recording will say so.")
@click.option("--json", "as_json", is_flag=True, help="One JSON document on stdout.")
def command(
    file: Path,
    out: Path | None,
    only_guess: bool,
    mapping: tuple[str, ...],
    topic: str | None,
    names: str | None,
    rig_file: Path | None,
    mechanism: str | None,
    joints: str | None,
    torque_map: str | None,
    gain: str | None,
    kt: str | None,
    gravity: bool,
    start: str | None,
    robot: str | None,
    simulated: bool,
    as_json: bool,
) -> None:
    """Turn measurements of another program into a recording for `ident`.

    DATA is a table (CSV and other text of any make, TwinCAT Scope, Parquet, NPZ, MAT) or a ROS 2 bag with
    sensor_msgs/JointState (.mcap, .db3, or its folder).

    A table has columns time (s, strictly increasing, even or not), position_1 ... position_n (rad), and voltage_i
    (V), effort_i (N m) or current_i (A). Optional: velocity_i, command_i, temperature_i (degC), and cycle, the number
    of the repetition, or -1; without it repetitions are found from the motion. Columns with other names or units are
    given with --map, or their units stand in brackets in the header; --guess proposes them. Other columns of numbers
    are kept. An empty cell or NaN is a gap.

    Three joints without --rig and --mechanism are the delta robot of the paper.
    """
    from recordings.importing import Choice, import_data
    from recordings.importing.dates import iso_date
    from recordings.importing.observations import observe
    from recordings.importing.table import Selection

    choice = Choice(mapping, Selection(topic, _parts("--names", names)))
    if only_guess:
        _guess(file, choice, as_json)
        return
    if out is None:
        raise click.UsageError(f"--out expected; name the recording to write, as in --out {file.stem}.mcap")
    _check_out(out)
    torque = {
        **({"map": torque_map} if torque_map else {}),
        **({"gain": _numbers("--gain", gain)} if gain is not None else {}),
        **({"per_ampere": _numbers("--kt", kt)} if kt is not None else {}),
    }
    described = replace(
        _description(rig_file, mechanism, joints, torque, gravity),
        simulated=simulated,
        start=iso_date("--start", start) if start is not None else None,
        robot=_name("--robot", robot),
    )
    imported = import_data(file, out, described, choice)
    seen = observe(imported)
    figures = _figures(imported, out, seen)
    if as_json:
        click.echo(json.dumps(figures))
    else:
        _show(figures, imported, seen)


def _check_out(out: Path) -> None:
    from recordings.errors import BadInput

    if out.suffix != ".mcap":
        raise BadInput(f"--out: a recording's name (.mcap) expected, {out} found; give it that ending")


def _guess(file: Path, choice: "Choice", as_json: bool) -> None:
    """Print what each column is taken for, and the command that says so."""
    from recordings.errors import BadInput
    from recordings.importing.proposal import propose

    if choice.mapping:
        raise BadInput("--guess proposes a mapping, --map found as well; leave one of them out")
    proposal = propose(file, choice.selection, _given_options())
    for line in [json.dumps(proposal.as_json())] if as_json else proposal.lines():
        click.echo(line)


def _given_options() -> list[str]:
    """Options of this call that describe the machine, as they were given."""
    context = click.get_current_context()
    words: list[str] = []
    for parameter in context.command.params:
        value = context.params.get(parameter.name or "")
        if value and parameter.opts[0] in _DESCRIBING:
            words += [parameter.opts[0], *([] if value is True else [str(value)])]
    return words


def _description(
    rig_file: Path | None, mechanism: Any, joints: str | None, torque: dict[str, Any], gravity: bool
) -> "Description":
    from recordings.errors import BadInput
    from recordings.importing import Description
    from recordings.rig import load_rig

    if rig_file is not None:
        if any((mechanism, joints, torque, gravity)):
            options = "--mechanism, --joints, --torque-map, --gain, --kt, --gravity"
            raise BadInput(f"either --rig or {options} expected, both found; leave one out")
        return Description(rig=load_rig(rig_file, driven=False))
    if joints is not None and mechanism != "axes":
        raise BadInput("--joints describes the axes of --mechanism axes; add it, or leave --joints out")
    return Description(mechanism=mechanism, joints=_kinds(joints), torque=torque or None, gravity=gravity)


def _kinds(joints: str | None) -> Any:
    from recordings.errors import BadInput

    kinds = tuple(kind.strip() for kind in (joints or "revolute").split(","))
    for kind in kinds:
        if kind not in ("revolute", "prismatic"):
            raise BadInput(f"--joints: revolute or prismatic expected, {kind!r} found; choose from these")
    return kinds


def _parts(option: str, text: str | None) -> tuple[str, ...]:
    from recordings.errors import BadInput

    parts = tuple(part.strip() for part in text.split(",")) if text is not None else ()
    if "" in parts or len(set(parts)) < len(parts):
        raise BadInput(f"{option}: names such as a,b,c, each once, expected, {text!r} found; correct the list")
    return parts


def _name(option: str, text: str | None) -> str | None:
    from recordings.errors import BadInput

    if text is not None and not text.strip():
        raise BadInput(f"{option}: a name expected, {text!r} found; give one, or leave the option out")
    return text


def _numbers(option: str, text: str) -> list[float]:
    from recordings.errors import BadInput

    try:
        numbers = [float(number) for number in text.split(",")]
    except ValueError:
        raise BadInput(f"{option}: numbers such as 1.0 or 1.0,0.9,1.1 expected, {text!r} found; correct it") from None
    if not all(0 < number < math.inf for number in numbers):
        raise BadInput(f"{option}: numbers above 0 expected, {text!r} found; turn a sign by --map and a factor *-1")
    return numbers


def _figures(imported: "Imported", out: Path, seen: "list[Observation]") -> dict[str, Any]:
    import numpy as np

    steps, samples = imported.steps, imported.samples
    return {
        "schema": 1,
        "recording": str(out),
        "rig": imported.rig.name,
        "mechanism": imported.rig.mechanism,
        "joints": imported.rig.dof,
        "samples": len(samples.stamp),
        "duration_s": float(steps.sum()),
        "step_s": {"min": float(steps.min()), "median": float(np.median(steps)), "max": float(steps.max())},
        "gaps": np.isnan(samples.position).sum(axis=0).tolist(),
        "cycles": int(samples.repeat.max()) + 1,
        "period_s": imported.run.period,
        "start": imported.run.start,
        "robot": imported.run.robot,
        "extra": list(samples.extra),
        "notes": list(imported.notes),
        "observations": [{"name": o.name, "level": o.level, "joint": o.joint, "says": o.says} for o in seen],
    }


def _show(figures: dict[str, Any], imported: "Imported", seen: "list[Observation]") -> None:
    step = {name: f"{value * 1e3:g} ms" for name, value in figures["step_s"].items()}
    cycles = f"{figures['cycles']} of {figures['period_s']:g} s" if figures["cycles"] else "none found"
    click.echo(f"joints: {figures['joints']} ({figures['mechanism']})")
    click.echo(f"samples: {figures['samples']} in {figures['duration_s']:g} s")
    click.echo(f"steps: {step['median']}, from {step['min']} to {step['max']}")
    click.echo(f"gaps: {_gaps(figures['gaps'], seen)}")
    click.echo(f"cycles: {cycles}")
    if figures["extra"]:
        click.echo(f"kept as extra channel: {', '.join(figures['extra'])}")
    for note in imported.notes:
        click.echo(note)
    for first, *others in _by_kind(seen):
        likewise = f" (likewise joint {', '.join(str(other.joint) for other in others)})" if others else ""
        warning = first.level == "warning"
        click.echo(f"{'warning: ' if warning else ''}{first.says}{likewise}", err=warning)
    torque = imported.rig.torque
    if imported.samples.voltage is not None and torque.gain_source == "assumed":
        click.echo(
            "torque gain: assumed, so a fit will be relative; --gain or a rig file can say otherwise", err=True
        )
    click.echo(f"imported {figures['recording']}; next: ident check {shlex.quote(figures['recording'])}")


def _gaps(positions: list[int], seen: "list[Observation]") -> str:
    """Number of gaps in the position of each joint, and whether time has gaps, too."""
    kinds = [", ".join(map(str, positions))] if any(positions) else []
    kinds += ["in time"] if any(observation.name == "time-gaps" for observation in seen) else []
    return "; ".join(kinds) or "none"


def _by_kind(seen: "list[Observation]") -> "list[list[Observation]]":
    """Observations of one kind about several joints together, in the order of the first."""
    groups: dict[str, list[Observation]] = {}
    for observation in seen:
        key = observation.name if observation.joint else observation.says
        groups.setdefault(key, []).append(observation)
    return list(groups.values())
