"""`ident check`: what recordings can show."""

from pathlib import Path

import click

from ident.command_options import EFFECT_FILES
from recordings.command_line import FiniteRange, check_readable, repeated, say_next
from recordings.next_command import diagnosis

FILE = click.Path(path_type=Path)


@click.command(
    short_help="Tell which effects a recording can show, and what to record to see the others.",
    epilog="Example: ident check fig5a.mcap",
)
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=FILE)
@click.option(
    "--share",
    type=FiniteRange(0.0001, 1.0),
    default=0.03,
    show_default=True,
    help="Size of the effects: RMS of their torque, as a share of that of the joint.",
)
@EFFECT_FILES
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of tables.")
def command(files: tuple[Path, ...], share: float, effect_files: tuple[Path, ...], as_json: bool) -> None:
    """Tell what the recordings FILE can show: sampling, resolution, motions, and which effects.

    Every effect of the library (ident effects) is visible, visible but not to be told from others, or not visible,
    with the smallest size that shows, and the motion to record if that is not enough. Nothing is diagnosed.
    """
    check_readable(*files)

    import json

    from rich.console import Console

    from ident.diagnosis.visibility.check import check
    from ident.dynamics.effects.library import library
    from ident.output.console import check as console_tables
    from recordings.progress import progress_bar

    with progress_bar("reading") as progress:
        document = check(files, library(effect_files), share, progress)
    if as_json:
        click.echo(json.dumps(document.as_json(), indent=2, allow_nan=False))
    else:
        console_tables.show(document, Console())
    say_next(*diagnosis(files, *repeated("--effect-file", effect_files)))
