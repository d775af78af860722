"""`ident table2`: the paper's comparison of identification methods."""

from pathlib import Path

import click

from ident import plugins
from recordings.command_line import NameChoice, refuse_existing, say_next
from recordings.errors import BadInput

FILE = click.Path(path_type=Path)


@click.command(epilog="Example: ident table2 fig5a.mcap fig5b.mcap")
@click.argument("files", metavar="[IDENTIFICATION VALIDATION]", nargs=-1, type=FILE)
@click.option(
    "--preprocess",
    type=NameChoice(plugins.names("ident.data.preprocessing")),
    default="central",
    show_default=True,
    help="As for `ident fit`; central is the paper's.",
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of the swarms.")
@click.option(
    "--plots", type=FILE, metavar="DIR", default=Path("table2.plots"), show_default=True, help="Folder of pictures."
)
@click.option("--force", is_flag=True, help="Replace existing pictures.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of tables.")
def command(files: tuple[Path, ...], preprocess: str, seed: int, plots: Path, force: bool, as_json: bool) -> None:
    """Identify by every method from one recording of a delta robot and validate on another.

    Prints Table 2 of the paper beside the paper's values and draws its Figures 3 and 6 to 10. Without arguments, uses
    the two samples that come with this software: a simulated robot on the paths fig5a and fig5b.
    """
    if len(files) not in (0, 2):
        raise BadInput(f"two recordings expected, to identify and to validate, {len(files)} found; give both or none")
    refuse_existing(plots, force=force)
    import json

    from rich.console import Console

    from ident.paper import figures, methods, table

    comparison = methods.compare_methods(files or _samples(), preprocess, seed, lambda *_: None)
    plots.mkdir(exist_ok=True)
    figures.draw(comparison, plots)
    if as_json:
        click.echo(json.dumps(methods.as_json(comparison, preprocess, seed), indent=2, allow_nan=False))
    else:
        table.show(comparison, Console())
    click.echo(f"pictures: {plots}", err=True)
    train, validation = files or _samples()
    say_next("ident", "diagnose", train, "--validate", validation)


def _samples() -> tuple[Path, Path]:
    import recordings

    folder = Path(recordings.__path__[0]) / "samples"
    return folder / "fig5a.mcap", folder / "fig5b.mcap"
