"""Methods found by file name: one method is one module in a folder of this package, named as the user types it."""

import importlib
import pkgutil
from pathlib import Path
from types import ModuleType

from recordings.errors import BadInput


def names(folder: str) -> tuple[str, ...]:
    """Names of the modules in `folder` (say "estimators"), without importing anything."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules([str(Path(__file__).with_name(folder))])))


def load(folder: str, name: str) -> ModuleType:
    """Import the module `name` of `folder`.

    Raises:
        BadInput: there is no such module.
    """
    if name not in names(folder):
        raise BadInput(f"{folder}: one of {', '.join(names(folder))} expected, '{name}' found; choose one of these")
    return importlib.import_module(f"ident.{folder}.{name}")
