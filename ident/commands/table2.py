"""`ident table2`: the paper's comparison of identification methods."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ident.basics import plugins
from ident.command_options import FILE, JSON, show_result
from recordings.command_line import IntegerRange, NameChoice, output_name, refuse_existing, say_next
from recordings.errors import BadInput, did_you_mean
from recordings.next_command import diagnosis

if TYPE_CHECKING:
    from rich.console import Console

    from ident.paper.methods import MethodComparison
    from ident.paper.study import SwarmStudy

SEEDS = 10
"""Number of seeds of a study of swarm sizes, unless it is given."""
SIZES = "300"
"""Swarm size of a study of seeds, unless it is given: the paper's."""
MOST_SIZES = 8
"""Limit of the width of a picture."""


@click.command(
    epilog="Examples: ident table2 fig5a.mcap fig5b.mcap; ident table2 --seeds 10 --sizes 50,100,300",
)
@click.argument("files", metavar="[IDENTIFICATION VALIDATION]", nargs=-1, type=FILE)
@click.option(
    "--preprocess",
    type=NameChoice(plugins.names("ident.data.preprocessing")),
    default="central",
    show_default=True,
    help="As for `ident fit`; central is the paper's.",
)
@click.option(
    "--set",
    "settings",
    metavar="METHOD.NAME=VALUE",
    multiple=True,
    help="Change a setting of a method (see ident methods), such as svd.threshold=0.3. May be repeated.",
)
@click.option("--seed", type=IntegerRange(min=0), default=0, show_default=True, help="Seed of the swarms.")
@click.option(
    "--seeds",
    type=IntegerRange(1, 1000),
    metavar="N",
    help=f"Study Remarks 1 and 2: cyclic and classical swarms from N seeds.  [default with --sizes: {SEEDS}]",
)
@click.option(
    "--sizes",
    metavar="N,N,...",
    help=f"Study Remarks 1 and 2 with swarms of these numbers of particles.  [default with --seeds: {SIZES}]",
)
@click.option(
    "--plots",
    type=FILE,
    metavar="DIR",
    help="Folder of pictures and their data (CSV).  [default: table2.plots]",
)
@click.option("--force", is_flag=True, help="Replace existing pictures.")
@JSON
def command(
    files: tuple[Path, ...],
    preprocess: str,
    settings: tuple[str, ...],
    seed: int,
    seeds: int | None,
    sizes: str | None,
    plots: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Identify by every method from one recording of a delta robot and validate on another.

    Prints Table 2 of the paper beside the paper's values and draws its Figures 3 and 6 to 10, each with its data as
    CSV. With --seeds or --sizes, also measures what Remarks 1 and 2 say of swarms. Without arguments, uses the two
    samples that come with this software: a simulated robot on the paths fig5a and fig5b.
    """
    if len(files) not in (0, 2):
        raise BadInput(f"two recordings expected, to identify and to validate, {len(files)} found; give both or none")
    numbers = _sizes(sizes or SIZES)
    of_method = _settings(settings)
    plots = output_name(plots, Path("table2.plots"), force)
    refuse_existing(plots, force=force)

    from functools import partial

    from ident.output.pictures import staged_folder
    from ident.paper import figures, study_views
    from ident.paper.methods import compare_methods
    from ident.paper.study import study_swarms
    from recordings.progress import progress_bar

    study = None
    with progress_bar("comparing methods") as show:
        comparison = compare_methods(
            files or _samples(),
            preprocess,
            seed,
            lambda done, total, *_: show("comparing methods", done, total),
            of_method,
        )
        if seeds or sizes:
            study = study_swarms(
                comparison,
                range(seed, seed + (seeds or SEEDS)),
                numbers,
                of_method,
                lambda done, total, *_: show("studying swarms", done, total),
            )
    with staged_folder(plots) as folder:
        figures.draw(comparison, folder)
        if study:
            study_views.draw(study, folder / "study.png")
            study_views.write(study, folder)
    show_result(as_json, partial(_document, comparison, study, preprocess, seed), partial(_show, comparison, study))
    click.echo(f"pictures and their data: {plots}", err=True)
    train, validation = files or _samples()
    say_next(*diagnosis([train], "--validate", validation))


def _document(comparison: MethodComparison, study: SwarmStudy | None, preprocess: str, seed: int) -> dict[str, Any]:
    from ident.paper import methods
    from ident.paper import study as swarms

    document = methods.as_json(comparison, preprocess, seed)
    return {**document, "study": swarms.as_json(study)} if study else document


def _show(comparison: MethodComparison, study: SwarmStudy | None, console: Console) -> None:
    from ident.paper import study_views, table

    table.show(comparison, console)
    if study:
        study_views.show(study, console)


def _sizes(text: str) -> list[int]:
    """Numbers of particles, as typed."""
    if not re.fullmatch(r"\d{1,6}(,\d{1,6})*", text):
        raise BadInput(f"--sizes: numbers of particles such as 50,100,300 expected, '{text}' found; write them so")
    numbers = list(dict.fromkeys(int(number) for number in text.split(",")))
    if min(numbers) < 3 or len(numbers) > MOST_SIZES:
        raise BadInput(
            f"--sizes: at most {MOST_SIZES} numbers, each of 3 or more, expected, '{text}' found; change them"
        )
    return numbers


def _settings(texts: tuple[str, ...]) -> Mapping[str, Mapping[str, Any]]:
    """Settings by method and name, as typed: METHOD.NAME=VALUE."""
    from ident.estimation.settings import parse
    from ident.paper.methods import NAMES

    of_method: dict[str, dict[str, str]] = {}
    for key, value in parse(texts).items():
        method, dot, name = key.partition(".")
        if not dot or method not in NAMES:
            raise BadInput(
                f"--set: METHOD.NAME=VALUE with a method of {', '.join(NAMES)} expected, '{key}' found;"
                f"{did_you_mean(method, NAMES)} `ident methods` explains them"
            )
        of_method.setdefault(method, {})[name] = value
    return of_method


def _samples() -> tuple[Path, Path]:
    import recordings

    folder = Path(recordings.__path__[0]) / "samples"
    return folder / "fig5a.mcap", folder / "fig5b.mcap"
