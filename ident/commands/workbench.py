"""`ident workbench`: the application in the browser on this machine."""

from pathlib import Path

import click

FILE = click.Path(path_type=Path)


@click.command(
    short_help="Work in the browser: record, fit, compare, find and add missing effects.",
    epilog="Example: ident workbench runs/",
)
@click.argument("places", metavar="[FOLDER | FILE...]", nargs=-1, type=FILE)
@click.option("--port", type=click.IntRange(1, 65535), help="[default: any that is free]")
@click.option("--no-browser", is_flag=True, help="Only print the address.")
@click.option(
    "--effect-file",
    "effect_files",
    multiple=True,
    type=FILE,
    metavar="PY",
    help="Python file with an effect of your own. It is executed.",
)
def command(places: tuple[Path, ...], port: int | None, no_browser: bool, effect_files: tuple[Path, ...]) -> None:
    """Open a page in the browser to record, fit, compare and find the effects that the model lacks.

    FOLDER holds the recordings; results are written there. Of two FILEs the first is fitted, the second validates.
    The page can access only this folder, and only this machine's user can open it.
    """
    from ident.workbench.app import serve
    from ident.workbench.session import open_session

    serve(open_session(places, effect_files), port, not no_browser)
