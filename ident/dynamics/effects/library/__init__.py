"""The library of effects. One effect is one file here, named as users type it.

Its module holds the description `effect`. An effect of the user is a file of the same kind, given by its path.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from ident.basics import plugins
from ident.dynamics.effects import adopted
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.user_files import from_file
from recordings.errors import BadInput


def names() -> tuple[str, ...]:
    """Return the names of the effects that come with this software."""
    return plugins.names(__name__)


def load(name: str) -> Effect:
    """Return the effect `name`.

    Raises:
        BadInput: there is no such effect.
    """
    return plugins.load(__name__, name).effect.made_by(partial(load, name))


def library(files: Sequence[Path] = ()) -> dict[str, Effect]:
    """Return all effects by name: those that come with this software, adopted ones, and those of the user's `files`.

    A file stands in place of an adopted effect of its name.

    Raises:
        BadInput: a file is not an effect, or its name is taken.
    """
    effects = {name: load(name) for name in names()}
    given = {path.stem for path in files}
    for path in (*(each for each in adopted.files() if each.stem not in given), *files):
        if path.stem in effects:
            raise BadInput(
                f"effect file {path}: a name of its own expected, {path.stem} found twice; rename the file"
            )
        effects[path.stem] = from_file(path)
    return effects
