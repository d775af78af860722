"""`daq recover`: recovery of an interrupted recording."""

import json
from pathlib import Path

import click

from daq.command_options import FILE, JSON
from recordings.command_line import check_readable, output_name, refuse_together, say_next
from recordings.files import free_name


@click.command(short_help="Make an interrupted or damaged recording whole.", epilog="Example: daq recover run.mcap")
@click.argument("file", type=FILE)
@click.option("--out", type=FILE, help="Recording to write.  [default: FILE with .recovered.mcap]")
@click.option("--in-place", is_flag=True, help="Replace FILE instead of writing another one.")
@click.option("--rig", "rig_file", type=FILE, help="Rig file (TOML) in place of a record `rig` that is lost.")
@JSON
def command(file: Path, out: Path | None, in_place: bool, rig_file: Path | None, as_json: bool) -> None:
    """Copy everything intact in a recording that was cut off or damaged into a whole one, whose run ended with exit
    status 1.

    Says what was lost. If it was made by listening, and the program did not come to make the samples, they are made
    from the frames. An MCAP file of another program keeps its messages. FILE itself is not touched.
    """
    from daq.passive.recover import recover, recover_in_place
    from recordings.rig import load_rig

    refuse_together("--out", "--in-place", because="choose one")
    check_readable(file)
    target = file if in_place else output_name(out, file.with_suffix(".recovered.mcap"))
    rig = load_rig(rig_file, driven=False) if rig_file else None
    recovered = recover_in_place(file, rig) if in_place else recover(file, target, rig)
    kept = recovered.kept
    lost = {
        "rows": kept.lost_rows,
        "chunks": kept.lost_chunks,
        "bytes": kept.lost_bytes,
        "records": list(kept.lost_records),
    }
    if as_json:
        document = {"schema": 1, "rows": kept.rows, "lost": lost, "altered": kept.altered, "out": str(target)}
        click.echo(json.dumps(document | {"reconstructed": recovered.reconstructed, "foreign": kept.foreign}))
        return
    rows = "" if kept.foreign else f"{kept.rows} samples, "
    click.echo(f"kept: {rows}{kept.messages} messages of {kept.duration:.3f} s")
    click.echo(f"lost: {kept.loss}")
    if kept.altered:
        click.echo(f"altered: something beside the {kept.kind}, by the checksum of the file; check rig and run")
    following: tuple[object, ...] = ("daq", "info", target)
    if kept.foreign:
        following = ("daq", "import", target, "--out", free_name(target.with_suffix(".imported.mcap")))
    if "run" in kept.lost_records:
        click.echo("lost: the record of the run; its trajectory, rate and whether it was simulated are not known")
    if "rig" in kept.lost_records:
        click.echo(f"lost: the record of the rig; {f'{rig_file} stands for it' if rig else 'give a rig file for it'}")
        following = following if rig else ("daq", "recover", target, "--rig", "RIG.toml")
    if recovered.reconstructed:
        click.echo("samples: made from the frames that were heard")
    click.echo(f"recovered {target}")
    say_next(*following)
