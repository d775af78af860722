"""`daq import`: conversion of measurements of another program to a recording."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from daq import import_options
from daq.command_options import FILE, JSON, PAYLOAD
from recordings.command_line import IntegerRange, NameChoice, is_given, refuse_together, say_next
from recordings.errors import BadInput

if TYPE_CHECKING:
    from recordings.data_problems import DataProblem
    from recordings.importing import Description, Imported
    from recordings.importing.healing import TimeSpan
    from recordings.importing.observations import Observation
    from recordings.importing.proposal import ImportProposal
    from recordings.urdf import Payload

_DESCRIBING = ("--mechanism", "--joints", "--torque-map", "--gain", "--kt", "--gravity")
"""Options that stand for a rig file."""
_OF_LOGS = ("--rig", "--out", "--topic", "--start", "--robot", "--simulated", "--json")
"""Options that say something of a log of CAN frames."""
_HEALING = ("--trim", "--exclude", "--unwrap", "--thin", "--drop-outliers")
_OF_OURS = ("--rig", "--out", "--map", *_HEALING, "--json")
"""Options that mend a recording of ours."""
_REPEATED = {"--rig", *_DESCRIBING, "--payload", "--start", "--robot", "--simulated", *_HEALING}
"""Options that a proposed command repeats."""
_EPILOG = """\b
Examples:
  daq import bench.csv --out bench.mcap --rig rig.toml
  daq import scope.csv --guess
  daq import scope.csv --guess --yes --kt 0.12 --out scope.mcap
  daq import scope.csv --out scope.mcap --map "time=t:ms" --map "position_1=q1:deg" --map "current_1=i1:A" --kt 0.12
  daq import candump-2026-01-05.log --rig rig.toml --out bus.mcap
  daq import rosbag2_2026_01_05/ --out bag.mcap --topic /joint_states --names left,right,rear
  daq import axis.csv --out axis.mcap --mechanism axes --joints prismatic --torque-map linear --gain 12.5"""


@click.command(short_help="Turn measurements of another program into a recording.", epilog=_EPILOG)
@click.argument("file", metavar="DATA", type=FILE)
@click.option("--out", "-o", type=FILE, help="Recording to write (.mcap).")
@click.option(
    "--guess", "only_guess", is_flag=True, help="Say what each column may be, and the command; write nothing."
)
@click.option("--yes", "accepted", is_flag=True, help="Import at once what --guess proposes, if it lacks nothing.")
@click.option(
    "--map",
    "mapping",
    multiple=True,
    metavar="NAME=COLUMN:UNIT",
    help="A column and its unit; or a TOML file of such.",
)
@click.option(
    "--topic", help="Topic of joint states in a ROS bag, or bus in a log of candump.  [default: the only one]"
)
@click.option(
    "--names",
    metavar="A,B,...",
    callback=import_options.names,
    help="Joints to take, in the order of their numbers.  [default: all]",
)
@click.option("--rig", "rig_file", type=FILE, help="Rig file (TOML) that says what was measured.")
@click.option(
    "--mechanism", type=NameChoice(["delta", "axes"]), help="Without a rig file.  [default: delta for 3 joints]"
)
@click.option(
    "--joints",
    metavar="KIND,...",
    callback=import_options.kinds,
    help="revolute or prismatic, for all axes or one each.  [default: revolute]",
)
@click.option("--torque-map", type=NameChoice(["square", "linear"]), help="Torque = gain v|v|, or gain v.")
@click.option(
    "--gain",
    metavar="NUMBER,...",
    callback=import_options.numbers,
    help="N m/V^2 or N m/V (N for prismatic joints), for all joints or one each.",
)
@click.option(
    "--kt",
    metavar="NUMBER,...",
    callback=import_options.numbers,
    help="N m/A (N/A for prismatic joints) of current_i, for all joints or one each.",
)
@click.option("--gravity", is_flag=True, help="Gravity loads the joint; of --mechanism axes with a single axis.")
@click.option("--trim", metavar="FROM:TO", callback=import_options.spans, help="Keep these times alone [s].")
@click.option("--exclude", metavar="FROM:TO,...", callback=import_options.spans, help="Make gaps of these times [s].")
@click.option(
    "--unwrap",
    metavar="JOINT,...",
    callback=import_options.joint_numbers,
    help="Joints whose angles jump by whole turns.",
)
@click.option("--thin", type=IntegerRange(1), default=1, help="Keep one of so many samples: where new values come.")
@click.option("--drop-outliers", is_flag=True, help="Make gaps of single samples far outside of all others.")
@PAYLOAD
@click.option("--start", metavar="DATE", help="Time of the first sample, such as 2026-01-05T08:00:00Z.")
@click.option(
    "--robot", metavar="NAME", callback=import_options.name, help="Name of the robot, kept in the recording."
)
@click.option("--simulated", is_flag=True, help="The measurements come from a simulation; the recording will say so.")
@JSON
def command(
    file: Path,
    out: Path | None,
    only_guess: bool,
    accepted: bool,
    mapping: tuple[str, ...],
    topic: str | None,
    names: tuple[str, ...],
    as_json: bool,
    **described: Any,
) -> None:
    """Write the measurements in DATA, of another program, as a recording."""
    from daq import data_problems
    from daq.passive import candump
    from recordings.importing import import_data, is_ours
    from recordings.importing.observations import observe
    from recordings.importing.proposal import propose

    refuse_together("--guess", "--map", because="--guess proposes a mapping; leave one of them out")
    refuse_together("--rig", *_DESCRIBING, because="leave one out")
    if accepted and not only_guess:
        raise BadInput("--yes accepts what --guess proposes; add --guess, or leave --yes out")
    is_log = candump.recognises(file)
    if is_log:
        _check_log_options(file)
    elif not only_guess and is_ours(file) and (other := _given() - {"file", *_OF_OURS}):
        raise BadInput(
            f"{file} is a recording of ours: {', '.join(_OF_OURS)} expected, {min(other)} found; its rig and run are "
            "kept, so leave it out"
        )
    if only_guess:
        _guess(propose(file, _given_options(), out, topic, names), accepted=accepted, as_json=as_json)
        return
    if out is None:
        raise click.UsageError(f"--out expected; name the recording to write, as in --out {file.stem}.mcap")
    if out.suffix != ".mcap":
        raise BadInput(f"--out: a recording's name (.mcap) expected, {out} found; give it that ending")
    description = _description(**described)
    imported = (
        candump.import_log(file, out, description, topic)
        if is_log
        else import_data(file, out, description, mapping, topic, names)
    )
    seen = observe(imported)
    click.echo(f"{out}: asking `ident check` whether the data can be right", err=True)
    problems, unchecked = data_problems.of_file(out)
    problems = [*problems, *imported.healed]
    figures = _figures(imported, out, seen) | {"data_problems": [each.model_dump(mode="json") for each in problems]}
    if unchecked:
        figures["notes"].append(unchecked)
    if as_json:
        click.echo(json.dumps(figures))
    else:
        _show(figures, imported, seen, problems)


def _check_log_options(file: Path) -> None:
    """Check that only options are given that say something of a log of CAN frames, and a rig file."""
    given = _given()
    if "--rig" not in given or given - {"file", *_OF_LOGS}:
        raise BadInput(
            f"{file} is a log of CAN frames, and the rig file says what they carry: daq import {file} --rig RIG.toml "
            f"--out {file.stem}.mcap; beside these it takes {', '.join(_OF_LOGS[2:])}"
        )


def _given() -> set[str]:
    """Parameters that this call names."""
    return {parameter.opts[0] for parameter in click.get_current_context().command.params if is_given(parameter)}


def _guess(proposal: "ImportProposal", *, accepted: bool, as_json: bool) -> None:
    """Show what is proposed; where it is `accepted`, import it as if its command were pasted."""
    if not accepted:
        for line in [json.dumps(proposal.as_json())] if as_json else proposal.lines():
            click.echo(line)
        return
    if proposal.missing:
        for line in proposal.lines():
            click.echo(line, err=True)
        raise BadInput("--yes: a complete proposal expected, parts missing found; complete the command above")
    click.echo(f"accepted: {proposal.command}", err=True)
    arguments = [*proposal.arguments, *(["--json"] if as_json else [])]
    command.main(arguments, standalone_mode=False)


def _given_options() -> list[str]:
    """Options of this call that describe the machine, as they were given."""
    context, words = click.get_current_context(), []
    for parameter in context.command.params:
        value = context.params.get(parameter.name or "")
        if parameter.opts[0] in _REPEATED and is_given(parameter):
            values = value if isinstance(value, list | tuple) else [] if value is True else [value]
            words += [parameter.opts[0], *([",".join(map(str, values))] if values else [])]
    return words


def _description(
    rig_file: Path | None,
    mechanism: Any,
    joints: Any,
    torque_map: str | None,
    gain: list[float] | None,
    kt: list[float] | None,
    gravity: bool,
    mounted: "Payload | None",
    start: str | None,
    robot: str | None,
    simulated: bool,
    trim: "tuple[TimeSpan, ...]",
    **healing: Any,
) -> "Description":
    """What the options say of the machine and of the measurement."""
    from recordings.importing import Description
    from recordings.importing.dates import iso_date
    from recordings.importing.healing import Healing
    from recordings.rig import load_rig

    if len(trim) > 1:
        raise BadInput(f"--trim: one span of time expected, {len(trim)} found; leave out others by --exclude")
    if mechanism != "axes" and "--joints" in _given_options():
        raise BadInput("--joints describes the axes of --mechanism axes; add it, or leave --joints out")
    torque = {"map": torque_map, "gain": gain, "per_ampere": kt}
    return Description(
        rig=load_rig(rig_file, driven=False) if rig_file else None,
        mechanism=mechanism,
        joints=joints,
        torque={key: value for key, value in torque.items() if value is not None},
        gravity=gravity,
        payload=mounted,
        simulated=simulated,
        start=None if start is None else iso_date("--start", start),
        robot=robot,
        healing=Healing(trim=trim[0] if trim else None, **healing),
    )


def _figures(imported: "Imported", out: Path, seen: "list[Observation]") -> dict[str, Any]:
    import numpy as np

    steps, samples = imported.steps, imported.samples
    torque = samples.effort if samples.voltage is None else samples.voltage
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
        "torque_gaps": [] if torque is None else np.isnan(torque).sum(axis=0).tolist(),
        "cycles": int(samples.repeat.max()) + 1,
        "period_s": imported.run.period,
        "start": imported.run.start,
        "robot": imported.run.robot,
        "extra": list(samples.extra),
        "notes": list(imported.notes),
        "observations": [{"name": o.name, "level": o.level, "joint": o.joint, "says": o.says} for o in seen],
    }


def _show(
    figures: dict[str, Any], imported: "Imported", seen: "list[Observation]", problems: "list[DataProblem]"
) -> None:
    from recordings.data_problems import healing

    step = {name: f"{value * 1e3:g} ms" for name, value in figures["step_s"].items()}
    cycles = f"{figures['cycles']} of {figures['period_s']:g} s" if figures["period_s"] else "none found"
    click.echo(f"joints: {figures['joints']} ({figures['mechanism']})")
    click.echo(f"samples: {figures['samples']} in {figures['duration_s']:g} s")
    click.echo(f"steps: {step['median']}, from {step['min']} to {step['max']}")
    gaps = [", ".join(map(str, figures["gaps"]))] if any(figures["gaps"]) else []
    gaps += ["in torque"] if any(figures["torque_gaps"]) else []
    gaps += ["in time"] if any(observation.name == "time-gaps" for observation in seen) else []
    click.echo(f"gaps: {'; '.join(gaps) or 'none'}")
    click.echo(f"cycles: {cycles}")
    if figures["extra"]:
        click.echo(f"kept as extra channel: {', '.join(figures['extra'])}")
    for note in figures["notes"]:
        click.echo(note)
    for first, *others in _by_kind(seen):
        likewise = f" (likewise joint {', '.join(str(other.joint) for other in others)})" if others else ""
        warning = first.level == "warning"
        click.echo(f"{'warning: ' if warning else ''}{first.says}{likewise}", err=warning)
    torque = imported.rig.torque
    if imported.samples.voltage is not None and torque.gain_source == "assumed":
        click.echo(
            "torque gain: assumed, so a fit will be relative; --gain or torque.gain of a rig file can say otherwise",
            err=True,
        )
    for problem in problems:
        click.echo(f"data problem ({problem.kind}): {problem.why}\n  {problem.remedy}", err=True)
    click.echo(f"imported {figures['recording']}")
    say_next(*healing(problems) or ("ident", "check", figures["recording"]))


def _by_kind(seen: "list[Observation]") -> "list[list[Observation]]":
    """Observations of one kind about several joints together, in the order of the first."""
    groups: dict[str, list[Observation]] = {}
    for observation in seen:
        key = observation.name if observation.joint else observation.says
        groups.setdefault(key, []).append(observation)
    return list(groups.values())
