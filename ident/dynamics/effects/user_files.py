"""Effects from files of the user: what goes wrong inside of them is said with the file's name, not by a traceback."""

import ast
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects import earlier_files
from ident.dynamics.effects.base import Additive, Effect, Signal
from ident.dynamics.effects.validation import validation_error
from recordings.errors import BadInput
from recordings.recording import Floats

_Check = Callable[[tuple[Any, ...], Any], str | None]
"""From arguments and result: what is wrong with the result."""


def from_file(path: Path) -> Effect:
    """The effect that the Python file `path` describes. It is executed: only for files that the user named.

    Raises:
        BadInput: the file is missing, fails, or holds no effect.
    """
    if path.suffix != ".py" or not path.is_file():
        raise BadInput(f"effect file {path}: an existing Python file (.py) expected, none found; check the path")

    module = ModuleType(path.stem)
    module.__file__ = str(path)
    try:
        tree = earlier_files.translated(ast.parse(path.read_bytes()), path)
        exec(compile(tree, str(path), "exec", dont_inherit=True), vars(module))
    except BadInput:
        raise
    except (Exception, SystemExit) as error:  # whatever the user's code does
        raise BadInput(f"effect file {path}: {one_line(error)}; mend the file") from None
    effect: Any = getattr(module, "effect", None)
    if not isinstance(effect, (Additive, Signal)):
        raise BadInput(
            f"effect file {path}: a variable 'effect' that is an Additive or a Signal expected, "
            f"{type(effect).__name__} found; see docs/effects.md"
        )
    found = validation_error(effect)
    if found:
        raise BadInput(f"effect file {path}: {found}; mend the file")
    return guarded(effect, path)


def guarded(effect: Effect, path: Path) -> Effect:
    """The `effect` of the file `path`, whose functions raise BadInput for whatever goes wrong in them."""

    def guard(name: str, check: _Check) -> dict[str, Any]:
        function = getattr(effect, name)
        return {name: _guard(path, function, check)} if function else {}

    changed = guard("suggest", _anything)
    if isinstance(effect, Additive):
        changed |= guard(
            "columns", lambda arguments, result: _columns(arguments[0], result, len(effect.coefficients))
        )
    elif isinstance(effect, Signal):
        changed |= guard("position", _as_the_first) | guard("report", _as_the_first) | guard("rig", _anything)
    return replace(effect, **changed)


def _guard(path: Path, function: Callable[..., Any], check: _Check) -> Callable[..., Any]:
    name = getattr(function, "__name__", "a function")

    @wraps(function)
    def call(*arguments: Any) -> Any:
        for one in arguments:
            if isinstance(one, EffectInputs):
                _freeze(one)
        own = (one.copy() if isinstance(one, np.ndarray) else one for one in arguments)
        try:
            result = function(*own)
        except (Exception, SystemExit) as error:  # whatever the user's code does
            raise BadInput(f"effect file {path}: {name}: {one_line(error)}; mend the file") from None
        wrong = check(arguments, result)
        if wrong:
            raise BadInput(f"effect file {path}: {name}: {wrong}; mend the file")
        return result

    return call


def one_line(error: BaseException) -> str:
    """The `error` in one line."""
    return " ".join([type(error).__name__, *str(error).split()])


def _freeze(view: EffectInputs) -> None:
    """What one effect changed in place, all others would see changed."""
    for array in (view.time, *vars(view.motion).values()):
        array.flags.writeable = False


def _anything(arguments: tuple[Any, ...], result: Any) -> str | None:
    return None


def _columns(view: EffectInputs, result: Any, coefficients: int) -> str | None:
    expected = (*view.motion.position.shape, coefficients)
    wrong = _array(result, expected)
    if wrong:
        return wrong
    known = np.all([np.isfinite(x) for x in vars(view.motion).values()], axis=(0, 2))
    if not np.isfinite(result[known]).all():
        return "finite numbers where the motion is known expected, others found"
    return None


def _as_the_first(arguments: tuple[Any, ...], result: Any) -> str | None:
    first: Floats = arguments[0]
    return _array(result, first.shape)


def _array(result: Any, shape: tuple[int, ...]) -> str | None:
    found = f"{result.dtype} {result.shape}" if isinstance(result, np.ndarray) else type(result).__name__
    if not isinstance(result, np.ndarray) or result.shape != shape or result.dtype.kind not in "fiub":
        return f"an array of real numbers {shape} expected, {found} found"
    return None
