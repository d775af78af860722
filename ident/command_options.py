"""Options that several commands of `ident` have in common."""

from pathlib import Path

import click

from ident import plugins
from recordings.command_line import FiniteRange, NameChoice

EFFECT_FILES = click.option(
    "--effect-file",
    "effect_files",
    multiple=True,
    type=click.Path(path_type=Path),
    metavar="PY",
    help="Python file with an effect of your own. It is executed.",
)
PREPROCESS = click.option(
    "--preprocess",
    type=NameChoice(plugins.names("ident.data.preprocessing")),
    default="parallel",
    show_default=True,
    help="As in fit.",
)
CUTOFF = click.option(
    "--cutoff",
    type=FiniteRange(0.1),
    metavar="HZ",
    help="Cut-off of the low-pass (-3 dB).  [default: from the spectra]",
)
