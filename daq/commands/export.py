"""`daq export`: export of a recording to the format of another program."""

import json
from pathlib import Path

import click

from daq import exporting
from daq.command_options import FILE, JSON
from recordings.command_line import NameChoice, check_readable, output_name, say_next

_ENDINGS = {"candump": ".log"}


@click.command(
    short_help="Write a recording as CSV, Parquet, MAT or candump log.",
    epilog="Example: daq export run.mcap --to csv",
)
@click.argument("file", type=FILE)
@click.option("--to", "form", type=NameChoice(exporting.names()), required=True, help="Format.")
@click.option("--out", type=FILE, help="File to write.  [default: FILE with another ending]")
@JSON
def command(file: Path, form: str, out: Path | None, as_json: bool) -> None:
    """Write a recording in another program's format; units are SI, a gap is an empty cell, null or NaN.

    csv is the format that `daq import` reads. candump holds the bus frames, for the tools of can-utils; the others
    hold the samples.
    """
    check_readable(file)
    out = output_name(out, file.with_suffix(_ENDINGS.get(form, f".{form}")))
    written = exporting.export(file, form, out)
    if as_json:
        click.echo(json.dumps({"schema": 1, "recording": str(file), "format": form, "out": str(out)}))
    else:
        click.echo(f"{out}: {written}")
    say_next("ident", "fit", file)
