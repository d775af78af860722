"""`ident torque`: the torque and voltage that a path takes, with every cause apart."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ident import plugins
from ident.command_options import EFFECT_FILES
from ident.model_name import model_stem
from recordings.command_line import FiniteRange, NameChoice, check_readable, refuse_existing, say, say_next
from recordings.next_command import free_name

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ident.export.paths import TorquePath
    from ident.export.torque_table import TorqueSummary
    from ident.identification.model import Model
    from recordings.recording import Floats
    from recordings.rig import Rig

FILE = click.Path(path_type=Path)


@click.command(
    short_help="Torque of a path, by its causes.",
    epilog="Example: ident torque fig5a.model.json --traj fig5b -o fig5b.torque.csv",
)
@click.argument("model_path", metavar="MODEL", type=FILE)
@click.argument("recording", metavar="[FILE]", required=False, type=FILE)
@click.option("--traj", metavar="NAME", help="Trajectory, or a file of points, as for `daq record`.")
@click.option("--csv", "table", type=FILE, metavar="CSV", help="Even samples: time, and position_i or x, y, z.")
@click.option("--cycles", type=click.IntRange(min=1), metavar="N", help="Repetitions of the trajectory.")
@click.option(
    "--rate", type=FiniteRange(min=0, min_open=True), metavar="HZ", help="Rows of the trajectory per second."
)
@click.option("--rig", "rig_file", type=FILE, metavar="TOML", help="Rig that will move: that of the model.")
@click.option("--temperature", type=FiniteRange(min=-273.15), metavar="CELSIUS", help="Temperature of the drives.")
@EFFECT_FILES
@click.option("-o", "--out", type=FILE, metavar="FILE", help="Write the table: .csv, .parquet or .json.")
@click.option(
    "--to",
    "form",
    type=NameChoice(plugins.names("ident.export.tables")),
    help="Format of the table.  [default: by the ending of FILE]",
)
@click.option("--picture", type=FILE, metavar="PNG", help="Draw the causes over time, and their RMS.")
@click.option("--force", is_flag=True, help="Replace existing files.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of a table.")
def command(
    model_path: Path,
    recording: Path | None,
    traj: str | None,
    table: Path | None,
    cycles: int | None,
    rate: float | None,
    rig_file: Path | None,
    temperature: float | None,
    effect_files: tuple[Path, ...],
    out: Path | None,
    form: str | None,
    picture: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Compute the torque and the voltage of the model in the file MODEL along a path.

    The path is a trajectory, a table, or the motion of the recording FILE. The causes (inertia, coupling, Coriolis,
    gravity, friction, each effect) add up to the torque.
    """
    import json
    from contextlib import nullcontext

    import ident
    from ident.export import tables
    from ident.export.term_intervals import relative_half_widths
    from ident.export.torque_table import TorqueSummary
    from ident.export.torque_table import tables as torque_tables
    from recordings.errors import BadInput
    from recordings.files import replacement

    if sum(source is not None for source in (recording, traj, table)) != 1:
        raise BadInput("one of --traj, --csv and a recording expected; say along which path")
    if (cycles or rate) and not traj:
        raise BadInput("--cycles and --rate belong to --traj; a table and a recording have their own")
    if recording and temperature is not None:
        raise BadInput("--temperature belongs to a path that is given; a recording has its own temperatures")
    inputs = [path for path in (model_path, recording, table, rig_file, *effect_files) if path]
    check_readable(*inputs)
    refuse_existing(out, picture, force=force, read=inputs)
    write = tables.load(form or tables.format_of(out)) if out else None
    model = ident.load_model(model_path, effect_files)
    path = _chosen_path(model, _rig(model, rig_file), recording, traj, table, (cycles, rate, temperature))
    summary = TorqueSummary()
    widths = relative_half_widths(model, path.excerpt())
    with replacement(out) if out else nullcontext() as partial:
        chunks = torque_tables(model, path, summary)
        rows = write(chunks, partial) if write and partial else sum(len(chunk["time"]) for chunk in chunks)
    if picture:
        _draw(model, path, summary, widths, picture)
    if as_json:
        click.echo(json.dumps(_document(model, summary, widths), indent=1, allow_nan=False))
    else:
        _show(model, summary, widths)
    if model.stepped:
        say(f"stepped in time: {', '.join(model.stepped)}")
    if out:
        say(f"torque of {path.name}: {out}, {rows} rows")
    if picture:
        say(f"picture: {picture}")
    exported = free_name(model_path.with_name(f"{model_stem(model_path.name)}_c"))
    say_next("ident", "export", model_path, "--to", "c", "-o", exported)


def _rig(model: Model, rig_file: Path | None) -> Rig:
    """The rig that will move: that of the file, if it is the model's, else what the model knows of it."""
    from ident.identification.model import rig_of
    from ident.identification.prediction import check_same_machine
    from recordings.rig import load_rig

    if rig_file is None:
        return rig_of(model.file)
    rig = load_rig(rig_file, driven=False)
    check_same_machine(model.file, rig, f"the rig of the model expected: {{}} in {rig_file}")
    return rig


def _chosen_path(
    model: Model,
    rig: Rig,
    recording: Path | None,
    traj: str | None,
    table: Path | None,
    settings: tuple[int | None, float | None, float | None],
) -> TorquePath:
    from ident.export import paths

    cycles, rate, temperature = settings
    if recording:
        return paths.from_recording(recording, model.file)
    if table:
        return paths.from_table(table, rig).at_temperature(temperature)
    assert traj is not None
    return paths.from_trajectory(traj, rig, cycles, rate).at_temperature(temperature)


def _document(model: Model, summary: TorqueSummary, widths: Mapping[str, Floats] | None) -> dict[str, Any]:
    share = summary.share
    terms = {
        name: {"rms": rms.tolist(), "rms_ci95": _interval(rms, name, widths), "share": share[name].tolist()}
        for name, rms in summary.rms.items()
    }
    return {
        "schema": 1,
        "relative": model.file.relative,
        "stepped": list(model.stepped),
        "torque_rms": summary.torque_rms.tolist(),
        "torque_rms_ci95": _interval(summary.torque_rms, "torque", widths),
        "terms": terms,
    }


def _interval(rms: Floats, name: str, widths: Mapping[str, Floats] | None) -> list[list[float] | None]:
    """95 % interval of each joint's RMS; None where it is not known."""
    from math import isfinite

    if widths is None:
        return [None] * len(rms)
    pairs = [(float(x), float(x * width)) for x, width in zip(rms, widths[name], strict=True)]
    return [[max(x - half, 0.0), x + half] if isfinite(half) else None for x, half in pairs]


def _show(model: Model, summary: TorqueSummary, widths: Mapping[str, Floats] | None) -> None:
    from rich.console import Console
    from rich.table import Table

    rows = Table("RMS", *(f"joint {joint}" for joint in range(1, len(model.file.joints) + 1)))
    share = summary.share
    for name, rms in {**summary.rms, "torque": summary.torque_rms}.items():
        cells = []
        for joint, (x, interval) in enumerate(zip(rms, _interval(rms, name, widths), strict=True)):
            half = f" ±{interval[1] - x:.3f}" if interval else ""
            cells.append(f"{x:.3f}{half}" + (f" {share[name][joint]:.0%}" if name in share else ""))
        rows.add_row(name, *cells, style="bold" if name == "torque" else None)
    Console().print(rows)
    if model.file.relative:
        say("The torque gain is assumed: all torques are known up to one common factor.")


def _draw(
    model: Model, path: TorquePath, summary: TorqueSummary, widths: Mapping[str, Floats] | None, picture: Path
) -> None:
    """Draw the first seconds of the middle of the path."""
    from ident.export.torque_table import evaluate
    from ident.output import torque_picture
    from recordings.files import replacement

    chunk = path.excerpt()
    torque, terms = evaluate(model, chunk)
    rows = slice(0, int(torque_picture.LONGEST * path.rate))
    parts = {name: values[rows] for name, values in terms.items()}
    units = model.file.effort_units
    with replacement(picture) as partial:
        time = chunk.time[chunk.used][rows]
        torque_picture.draw(
            partial, f"{path.name}: torque by cause", time, torque[rows], parts, summary.rms, widths, units
        )
