"""`ident watch`: a model beside a recording that is finished, is being written, or comes through a pipe."""

from __future__ import annotations

import os
import sys
import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ident.command_options import ALARM, EFFECT_FILES, FILE
from recordings.command_line import FiniteRange, check_readable
from recordings.errors import BadInput

if TYPE_CHECKING:
    from ident.identification.model_file import ModelFile

_WAIT = 0.1
"""Pause before it is looked again whether a file is there [s]."""


@click.command(
    short_help="Follow a recording, and raise an alarm when the robot changes.",
    epilog="Example: ident watch fig5a.model.json run.mcap --healthy fig5a.mcap",
)
@click.argument("model_path", metavar="MODEL", type=FILE)
@click.argument("source", metavar="FILE|-", type=FILE)
@click.option(
    "--follow", is_flag=True, help="Wait for FILE, and at its end for more, until the recording is complete."
)
@click.option(
    "--healthy",
    multiple=True,
    type=FILE,
    metavar="FILE",
    help="Recording of the same motion on the healthy robot. May be repeated.  [default: those the model was "
    "validated with]",
)
@click.option(
    "--samples",
    type=FiniteRange(min=0, min_open=True),
    metavar="HZ",
    help="Add what a live view draws: torque, residual and causes, so many times a second.",
)
@click.option(
    "--track", metavar="NAME,...", help="Follow these parameters of the model, such as m_p,c_v1, with intervals."
)
@EFFECT_FILES
def command(
    model_path: Path,
    source: Path,
    follow: bool,
    healthy: tuple[Path, ...],
    samples: float | None,
    track: str | None,
    effect_files: tuple[Path, ...],
) -> None:
    """Compute the residual of the model in the file MODEL along a recording, and watch whether it changes.

    FILE is a recording of a motion that repeats; - reads an MCAP stream from stdin. Prints one JSON line per second
    of the recording, and one for the alarm. Exit code 3: an alarm was raised.
    """
    import json

    import ident
    from ident.watch.watching import Watch
    from recordings.following import pieces

    check_readable(model_path, *healthy)
    model = ident.load_model(model_path, effect_files=effect_files)
    recordings = healthy or _held_out(model.file, model_path)
    names = [name.strip() for name in track.split(",")] if track else []
    watch = Watch(model, recordings, samples, names)
    parent = os.getppid()

    def growing() -> bool:
        """Whether to wait for more; not when the program is gone that started this one, and may have written it."""
        return follow and os.getppid() == parent

    with ExitStack() as stack:
        if str(source) == "-":
            file = sys.stdin.buffer
        else:
            while growing() and not (source.is_file() and source.stat().st_size):
                time.sleep(_WAIT)
            check_readable(source)
            file = stack.enter_context(source.open("rb"))
        for line in watch.lines(pieces(file, source, growing=growing)):
            click.echo(json.dumps(line, allow_nan=False))
    if watch.alarmed:
        sys.exit(ALARM)


def _held_out(model: ModelFile, path: Path) -> list[Path]:
    """The recordings that `model` was validated with."""
    from ident.identification.model_file import find_recording

    sources = model.validate_.recordings if model.validate_ else ()
    found = [file for each in sources if (file := find_recording(each, path))]
    if not found:
        names = ", ".join(each.name for each in sources) or "the model was validated with none"
        raise BadInput(f"recordings of the healthy robot expected, not found: {names}; give them by --healthy")
    return found
