"""Loads effects from files of the user. Errors inside of them name the file and show no traceback."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial, wraps
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Effect, Signal
from ident.dynamics.effects.validation import validation_error
from recordings.errors import BadInput
from recordings.recording import Floats

_Check = Callable[[tuple[Any, ...], Any], str | None] | None
"""Returns what is wrong with the result, given arguments and result; None if nothing is."""


def from_file(path: Path) -> Effect:
    """Load the effect that the Python file `path` describes. It is executed: only for files that the user named.

    Raises:
        BadInput: the file is missing, fails, or holds no effect.
    """
    if path.suffix != ".py" or not path.is_file():
        raise BadInput(f"effect file {path}: an existing Python file (.py) expected, none found; check the path")
    return _from_source(path, path.read_bytes())


def _from_source(path: Path, source: bytes) -> Effect:
    """Load the effect of the file `path` from its content, which travels with the pickled effect."""
    module = ModuleType(path.stem)
    module.__file__ = str(path)
    try:
        exec(compile(source, str(path), "exec", dont_inherit=True), vars(module))
    except BadInput:
        raise
    except (Exception, SystemExit) as error:  # whatever the user's code does
        raise BadInput(f"effect file {path}: {one_line(error)}; mend the file") from None
    effect: Any = getattr(module, "effect", None)
    if not isinstance(effect, (Additive, Signal)):
        raise BadInput(
            f"effect file {path}: a variable 'effect' that is an Additive or a Signal expected, "
            f"{type(effect).__name__} found; see docs/how-to/your-own-effect.md"
        )
    if problem := validation_error(effect):
        raise BadInput(f"effect file {path}: {problem}; mend the file")
    return guarded(effect, path).made_by(partial(_from_source, path, source))


def guarded(effect: Effect, path: Path) -> Effect:
    """Return the `effect` of the file `path` with functions that raise BadInput for any error in them."""

    def guard(name: str, check: _Check = None) -> dict[str, Any]:
        function = getattr(effect, name)
        return {name: _guard(path, function, check)} if function else {}

    functions = guard("suggest")
    if isinstance(effect, Additive):
        functions |= guard("columns", lambda given, result: _columns_error(given[0], result, len(effect.parameters)))
    elif isinstance(effect, Signal):
        functions |= guard("report", lambda given, result: _array_error(result, given[0].shape)) | guard("rig")
    return replace(effect, **functions)


def _guard(path: Path, function: Callable[..., Any], check: _Check) -> Callable[..., Any]:
    name = getattr(function, "__name__", "a function")

    @wraps(function)
    def call(*arguments: Any) -> Any:
        for argument in arguments:
            if isinstance(argument, EffectInputs):
                _freeze(argument)
        copies = (argument.copy() if isinstance(argument, np.ndarray) else argument for argument in arguments)
        try:
            result = function(*copies)
        except BadInput:
            raise
        except (Exception, SystemExit) as error:  # whatever the user's code does
            raise BadInput(f"effect file {path}: {name}: {one_line(error)}; mend the file") from None
        if check and (problem := check(arguments, result)):
            raise BadInput(f"effect file {path}: {name}: {problem}; mend the file")
        return result

    return call


def one_line(error: BaseException) -> str:
    """Return the type and text of `error` in one line."""
    return " ".join([type(error).__name__, *str(error).split()])


def _freeze(inputs: EffectInputs) -> None:
    """Make the arrays read-only: all effects share them."""
    for array in (vars(inputs)["time"], *_signals(inputs)):
        array.flags.writeable = False


def _signals(inputs: EffectInputs) -> list[Floats]:
    """(n, dof) arrays of the motion."""
    return [value for value in vars(inputs.motion).values() if isinstance(value, np.ndarray)]


def _columns_error(inputs: EffectInputs, result: Any, coefficients: int) -> str | None:
    expected = (*inputs.motion.position.shape, coefficients)
    if problem := _array_error(result, expected):
        return problem
    known = np.all([np.isfinite(x) for x in _signals(inputs)], axis=(0, 2))
    if not np.isfinite(result[known]).all():
        return "finite numbers where the motion is known expected, others found"
    return None


def _array_error(result: Any, shape: tuple[int, ...]) -> str | None:
    kind = f"{result.dtype} {result.shape}" if isinstance(result, np.ndarray) else type(result).__name__
    if not isinstance(result, np.ndarray) or result.shape != shape or result.dtype.kind not in "fiub":
        return f"an array of real numbers {shape} expected, {kind} found"
    return None
