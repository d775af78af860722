"""`ident check`: what recordings can show."""

from pathlib import Path

import click

from ident.command_options import ACCEPT, EFFECT_FILES, FILE, JSON, DataCommand, again, show_result
from recordings.command_line import FiniteRange, check_readable, say_next
from recordings.next_command import diagnosis


@click.command(
    cls=DataCommand,
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
@ACCEPT
@click.option("--problems", "only_problems", is_flag=True, help="Tell only what cannot be right about the data.")
@JSON
def command(
    files: tuple[Path, ...],
    share: float,
    effect_files: tuple[Path, ...],
    accept: tuple[str, ...],
    only_problems: bool,
    as_json: bool,
) -> None:
    """Tell what the recordings FILE can show: sampling, resolution, motions, and which effects.

    Every effect of the library (ident effects) is visible, visible but not to be told from others, or not visible,
    with the smallest size that shows, and the motion to record if that is not enough. Nothing is diagnosed.
    """
    check_readable(*files)

    from functools import partial

    import ident
    from ident.data_problems import check_data
    from ident.output.console.check import show
    from ident.output.console.printing import show_problems
    from recordings.progress import progress_bar
    from recordings.reader import read

    if only_problems:
        listing = check_data([read(path) for path in files])
        show_result(as_json, listing.as_json, partial(show_problems, listing.data_problems))
        if not (as_json or listing.data_problems):
            click.echo("no data problem found")
        return
    with progress_bar("reading") as progress:
        document = ident.check(files, share=share, effect_files=effect_files, accept=accept, progress=progress)
    show_result(as_json, document.as_json, partial(show, document))
    say_next(*diagnosis(files, *again("--effect-file", "--accept")))
