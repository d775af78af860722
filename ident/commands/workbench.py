"""`ident workbench`: the application in the browser on this machine."""

from pathlib import Path

import click

from ident.command_options import EFFECT_FILES, FILE, PLACE
from recordings.command_line import IntegerRange, say_next
from recordings.errors import BadInput


@click.command(
    short_help="Work in the browser: record, fit, compare, find and add missing effects.",
    epilog="Example: ident workbench runs/",
)
@click.argument("places", metavar="[FOLDER | FILE...]", nargs=-1, type=FILE)
@click.option("--port", type=IntegerRange(1, 65535), help="[default: that of the last page of this folder]")
@click.option("--no-browser", is_flag=True, help="Only print the address.")
@EFFECT_FILES
@click.option("--store", type=PLACE, metavar="DIR", help="Show the fleet whose results are in this folder, too.")
def command(
    places: tuple[Path, ...],
    port: int | None,
    no_browser: bool,
    effect_files: tuple[Path, ...],
    store: Path | None,
) -> None:
    """Open a page in the browser to record, fit, compare and find the effects that the model lacks.

    FOLDER holds the recordings; results are written there. Of two FILEs the first is fitted, the second validates.
    The page can access only this folder, and only this machine's user can open it.
    """
    from ident.fleet.walk import is_store
    from ident.workbench.app import serve
    from ident.workbench.state.session import open_session

    if places and is_store(places[0]):
        raise BadInput(
            f"{places[0]}: a folder of recordings expected, a store of `ident fleet` found; say, "
            f"ident workbench --store {places[0]}"
        )
    session = open_session(places, effect_files, store)
    serve(session, port, not no_browser)
    say_next(*session.next_command())
