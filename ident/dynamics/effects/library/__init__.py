"""The library of effects. One effect is one file here, named as users type it.

Its module holds `effect`, a description that says all there is to know about it. A user's own effect is the same kind
of file, given by its path.
"""

from collections.abc import Sequence
from pathlib import Path

from ident import plugins
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.user_files import from_file
from recordings.errors import BadInput


def names() -> tuple[str, ...]:
    """Of the effects that come with this software."""
    return plugins.names(__name__)


def load(name: str) -> Effect:
    """The effect `name`. Raises BadInput where there is none."""
    effect: Effect = plugins.load(__name__, name).effect
    return effect


def library(files: Sequence[Path] = ()) -> dict[str, Effect]:
    """All effects by name: those that come with this software, and those of the user's `files`.

    Raises:
        BadInput: a file is not an effect, or its name is taken.
    """
    found = {name: load(name) for name in names()}
    for path in files:
        if path.stem in found:
            raise BadInput(
                f"effect file {path}: a name of its own expected, {path.stem} found twice; rename the file"
            )
        found[path.stem] = from_file(path)
    return found
