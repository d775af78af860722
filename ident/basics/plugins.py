"""Plugins found by file name: each is one module of a package, named as the user types it."""

import importlib
import importlib.util
import pkgutil
from types import ModuleType

from recordings.errors import BadInput


def names(package: str) -> tuple[str, ...]:
    """Return the names of the modules in `package` (say "ident.estimation.estimators") without importing them."""
    spec = importlib.util.find_spec(package)
    folders = spec.submodule_search_locations if spec else None
    return tuple(sorted(module.name for module in pkgutil.iter_modules(folders or [])))


def load(package: str, name: str) -> ModuleType:
    """Import the module `name` of `package`.

    Raises:
        BadInput: there is no such module.
    """
    if name not in names(package):
        known = f"{package.rpartition('.')[2]} {', '.join(names(package))}"
        raise BadInput(f"one of the {known} expected, '{name}' found; choose one of these")
    return importlib.import_module(f"{package}.{name}")
