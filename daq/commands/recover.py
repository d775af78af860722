"""`daq recover`: recovery of an interrupted recording."""

import json
from dataclasses import asdict
from pathlib import Path

import click

from daq.command_options import FILE, JSON
from recordings.command_line import refuse_together


@click.command(short_help="Make an interrupted or damaged recording whole.", epilog="Example: daq recover run.mcap")
@click.argument("file", type=FILE)
@click.option("--out", type=FILE, help="Recording to write.  [default: FILE with .recovered.mcap]")
@click.option("--in-place", is_flag=True, help="Replace FILE instead of writing another one.")
@JSON
def command(file: Path, out: Path | None, in_place: bool, as_json: bool) -> None:
    """Copy everything intact in a recording that was cut off or damaged into a whole one, with exit status 1.

    If it was made by listening, and the program did not come to make the samples, they are made from the frames.
    FILE itself is not touched.
    """
    from daq.passive.recover import recover, recover_in_place

    refuse_together("--out", "--in-place", because="choose one")
    target = file if in_place else out or file.with_suffix(".recovered.mcap")
    recovered = recover_in_place(file) if in_place else recover(file, target)
    if as_json:
        click.echo(json.dumps({"schema": 1, "recording": str(target), **asdict(recovered)}))
        return
    kept = recovered.kept
    click.echo(f"kept: {kept.messages} messages of {kept.duration:.3f} s")
    click.echo(f"left out: {kept.damaged_chunks} damaged chunks, {kept.bytes_behind} bytes of an unfinished one")
    if recovered.reconstructed:
        click.echo("samples: made from the frames that were heard")
    click.echo(f"recovered {target}; next: daq info {target}")
