"""`ident export`: a model for controllers and simulators."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, cast

import click

from ident.basics import plugins
from ident.command_options import EFFECT_FILES, FILE, RuledCommand, belongs, chosen_path, one_of
from recordings.command_line import FiniteRange, NameChoice, check_readable, refuse_existing, say


@click.command(
    cls=RuledCommand,
    rules=[
        one_of({name: name for name in ("--traj", "--csv", "--on")}, "say along which motion"),
        belongs(("--temperature",), "a motion that is given", "a recording has its own temperatures", ("--on",)),
    ],
    short_help="Write the model for a controller or a simulator.",
    epilog="Example: ident export fig5a.model.json --to c -o controller",
)
@click.argument("model_path", metavar="MODEL", type=FILE)
@click.option("--to", "target", required=True, type=NameChoice(plugins.names("ident.export.targets")))
@click.option("-o", "--out", required=True, type=FILE, metavar="PATH", help="File, or folder for c.")
@click.option("--traj", metavar="NAME", help="Motion of tables, test vectors and losses: a trajectory,")
@click.option("--csv", "table", type=FILE, metavar="CSV", help="or a table, as for `ident torque`,")
@click.option("--on", "recording", type=FILE, metavar="FILE", help="or a recording.  [default: of the fit, or fig5a]")
@click.option("--temperature", type=FiniteRange(min=-273.15), metavar="CELSIUS", help="Of the drives in that motion.")
@click.option("--precision", type=NameChoice(["double", "float"]), default="double", show_default=True)
@click.option(
    "--set",
    "settings",
    metavar="NAME=VALUE",
    multiple=True,
    help="Of c: prefix=NAME of functions and macros, smooth_velocity=SPEED within which friction is smooth; of fmu: "
    "plant=forward, fmi=3, smooth_velocity=SPEED.",
)
@EFFECT_FILES
@click.option("--force", is_flag=True, help="Replace existing files.")
@click.option("--json", "as_json", is_flag=True, help="Print the document about the losses.")
def command(
    model_path: Path,
    target: str,
    out: Path,
    traj: str | None,
    table: Path | None,
    recording: Path | None,
    temperature: float | None,
    precision: str,
    settings: tuple[str, ...],
    effect_files: tuple[Path, ...],
    force: bool,
    as_json: bool,
) -> None:
    """Write the model in the file MODEL as C99, a table, an FMU, a model for MuJoCo, a URDF, or beside a recording.

    A document beside it says which effects it carries, which not, and the torque that is lost.
    """
    import ident
    from ident.estimation.settings import parse
    from ident.export import exporting, targets
    from ident.identification.model import rig_of
    from ident.identification.model_file import find_recording
    from recordings.files import sha256

    given = parse(settings)
    targets.settings(target, given)
    inputs = [path for path in (model_path, table, recording, *effect_files) if path]
    carried_file = targets.load(target).carried_file(out)
    check_readable(*inputs)
    model = ident.load_model(model_path, effect_files=effect_files)
    # Else the first training recording, if it lies beside the model, or fig5a.
    path = chosen_path(model, rig_of(model.file), recording, table, traj, temperature) or exporting.motion(
        model, find_recording(model.file.train.recordings[0], model_path), temperature
    )
    refuse_existing(out, force=force, read=inputs, recording=target == "mcap")
    if out != carried_file.parent:
        refuse_existing(carried_file, force=force, read=inputs)
    precise = cast(Literal["double", "float"], precision)
    carried = exporting.export(model, target, out, path, precise, given, sha256(model_path))
    if as_json:
        click.echo(carried_file.read_text(encoding="utf-8"), nl=False)
    for name, why in carried.lost.items():
        say(f"not carried: {name} ({why})", "yellow")
    say(f"{target}: {out}; losses: {carried_file}")
