"""`ident torque`: the torque and voltage that a path takes, with every cause apart."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ident.basics import plugins
from ident.command_options import (
    EFFECT_FILES,
    FILE,
    JSON,
    RuledCommand,
    belongs,
    c_export,
    chosen_path,
    one_of,
    say_written,
    show_result,
)
from recordings.command_line import (
    FiniteRange,
    IntegerRange,
    NameChoice,
    check_readable,
    refuse_existing,
    say,
    say_next,
)

if TYPE_CHECKING:
    from ident.identification.model import Model
    from recordings.rig import Rig

_SOURCES = {"--traj": "--traj", "--csv": "--csv", "recording": "a recording"}
"""Of a path."""


@click.command(
    cls=RuledCommand,
    rules=[
        one_of(_SOURCES, "say along which path", least=1),
        belongs(("--cycles", "--rate"), "--traj", "a table and a recording have their own", ("--csv", "recording")),
        belongs(("--temperature",), "a path that is given", "a recording has its own temperatures", ("recording",)),
    ],
    short_help="Torque of a path, by its causes.",
    epilog="Example: ident torque fig5a.model.json --traj fig5b -o fig5b.torque.csv",
)
@click.argument("model_path", metavar="MODEL", type=FILE)
@click.argument("recording", metavar="[FILE]", required=False, type=FILE)
@click.option("--traj", metavar="NAME", help="Trajectory, or a file of points, as for `daq record`.")
@click.option("--csv", "table", type=FILE, metavar="CSV", help="Even samples: time, and position_i or x, y, z.")
@click.option("--cycles", type=IntegerRange(min=1), metavar="N", help="Repetitions of the trajectory.")
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
@JSON
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
    import ident
    from ident.export import tables, torque_table
    from ident.export.term_intervals import relative_half_widths
    from ident.output.console.printing import print_table
    from ident.output.tables import causes
    from recordings.files import replacement

    inputs = [path for path in (model_path, recording, table, rig_file, *effect_files) if path]
    check_readable(*inputs)
    write = tables.load(form or tables.format_of(out)) if out else None
    model = ident.load_model(model_path, effect_files=effect_files)
    path = chosen_path(model, _rig(model, rig_file), recording, table, traj, temperature, cycles, rate)
    assert path is not None, "one is given"
    refuse_existing(out, picture, force=force, read=inputs)
    summary = torque_table.TorqueSummary()
    widths = relative_half_widths(model, path.excerpt())
    with replacement(out) if out else nullcontext() as partial:
        chunks = torque_table.tables(model, path, summary)
        rows = write(chunks, partial) if write and partial else sum(len(chunk["time"]) for chunk in chunks)
    if picture:
        from ident.output.pictures import torque_by_cause

        torque_by_cause(picture, model, path, summary.rms, widths)
    show_result(
        as_json,
        lambda: causes.document(model, summary, widths),
        lambda console: print_table(console, causes.table(summary, widths)),
    )
    if model.file.relative and not as_json:
        say("The torque gain is assumed: all torques are known up to one common factor.")
    if model.stepped:
        say(f"stepped in time: {', '.join(model.stepped)}")
    if out:
        say(f"torque of {path.name}: {out}, {rows} rows")
    say_written(picture=picture)
    say_next(*c_export(model_path))


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
