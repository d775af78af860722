"""Effect files written for earlier versions: they load unchanged.

Earlier versions kept what an effect file imports in other modules, and had other names for some of it. `translated`
redirects the imports of such a file to this module, which holds everything under its earlier name.
"""

import ast
import importlib
from collections.abc import Callable
from functools import wraps
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ident.dynamics import flexible_joints, rods, torque_map
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects import base, learned_curve
from ident.dynamics.effects.base import Shapes as Shapes
from ident.dynamics.effects.base import Suggestion as Suggestion
from ident.dynamics.effects.base import Values as Values
from ident.dynamics.effects.learned_curve import Variable as Variable
from ident.dynamics.motion import Motion as Motion
from ident.dynamics.platform import Platform as Platform
from ident.dynamics.platform import platform as platform
from ident.dynamics.rods import GRAVITY as GRAVITY
from ident.dynamics.rods import torque as torque
from ident.filters import contiguous_slices
from ident.filters import convolve as convolve
from ident.filters import first_derivative as first_derivative
from ident.filters import low_pass as low_pass
from ident.filters import mean_sign as mean_sign
from ident.filters import second_derivative as second_derivative
from ident.numba_cache import compiled as compiled
from recordings.errors import BadInput

Axis = base.SignatureAxis
NEVER = base.INFINITE_TIME
Times = learned_curve.Multiplier
is_never = base.is_infinite
effect_of = learned_curve.learned_effect
source = learned_curve.effect_file_text
stretches = contiguous_slices
own_inertia = flexible_joints.joint_inertia
pull = rods.horizontal_gravity_torque
not_a_command = torque_map.amplifier_unobservable

_COLLECTED = (
    "ident.arms", "ident.compiled", "ident.effects", "ident.forearms", "ident.motion",
    "ident.platform", "ident.signals", "ident.stand_in", "ident.torque_map", "ident.view",
)  # fmt: skip
"""Earlier modules whose contents are in this module."""
_MOVED = {
    "ident.effects": "ident.dynamics.effects.library",
    "ident.forms": "ident.dynamics.forms",
    "ident.mechanisms": "ident.dynamics.mechanisms",
}
"""Earlier packages: present package of their submodules."""
_LIBRARY = ("names", "load", "library", "from_file")
"""Functions of the library of effects, which reads effect files itself and is therefore imported on demand."""
_RENAMED = {
    "starts": "initial_guesses",
    "open": "implausible_bound",
    "looks": "symptom",
    "always_true": "mandatory",
    "valleys": "multistart",
    "of_joint": "variable_joint",
    "times": "multiplier",
    "signal": "variable_values",
    "calmed": "low_passed",
    "arms": "flexible_joints",
    "every": "decimated",
    "numbers": "constants",
    "following": "rigid_torque",
    "on_springs": "elastic_torque",
    "ratio": "damping_ratio",
    "with_play": "backlash_torque",
    "half": "half_gap",
    "swings": "natural_frequencies",
    "falls": "cost_reductions",
    "own": "joint_inertias",
    "shares": "motor_shares",
    "halves": "half_gaps",
}
"""Attributes and keywords: present name by earlier name."""


def _with_keywords(function: Callable[..., Any], renamed: dict[str, str]) -> Callable[..., Any]:
    """Let `function` accept `renamed` keywords; its arguments and result answer to earlier names."""

    @wraps(function)
    def call(*arguments: Any, **keywords: Any) -> Any:
        present = {renamed.get(name, name): value for name, value in keywords.items()}
        return _with_names(function(*map(_with_names, arguments), **present))

    return call


class _Names:
    """Adds the earlier names of attributes."""

    def __getattr__(self, name: str) -> Any:
        if name not in _RENAMED:
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        value = getattr(self, _RENAMED[name])
        return _with_keywords(value, _RENAMED) if callable(value) else value


class _Description(_Names):
    """Adds the earlier keywords; functions among them receive inputs that answer to earlier names."""

    def __init__(self, *arguments: Any, **keywords: Any) -> None:
        present = {name: value for name, value in keywords.items() if name not in _RENAMED}
        present |= {_RENAMED[name]: value for name, value in keywords.items() if name in _RENAMED}
        functions = {name: _with_keywords(value, {}) for name, value in present.items() if callable(value)}
        super().__init__(*arguments, **present | functions)


class View(_Names, EffectInputs):
    """Effect inputs."""


class Arms(_Names, flexible_joints.FlexibleJoints):
    """Flexible joints."""


class Quantity(_Description, base.Quantity):
    """A parameter of an effect."""


class Effect(_Description, base.Effect):
    """An effect of either kind."""


class Additive(_Description, base.Additive):
    """An effect that is further torque."""


class Signal(_Description, base.Signal):
    """An effect that distorts what is measured."""


class Curve(_Description, learned_curve.LearnedCurve):
    """A learned curve."""


arms = _with_keywords(flexible_joints.flexible_joints, {})
torque_from_voltage = _with_keywords(torque_map.torque_from_voltage, {"torque": "torque_map"})
torque_per_volt = _with_keywords(torque_map.torque_per_volt, {"torque": "torque_map"})
voltage_from_torque = _with_keywords(torque_map.voltage_from_torque, {"map_": "torque_map"})


def _with_names(value: Any) -> Any:
    """Return `value`, as an object of the class with the earlier names if there is one."""
    for present, earlier in ((EffectInputs, View), (flexible_joints.FlexibleJoints, Arms)):
        if type(value) is present:
            twin = object.__new__(earlier)
            object.__setattr__(twin, "__dict__", value.__dict__)  # shared, including cached properties
            return twin
    return value


def __getattr__(name: str) -> Any:
    """Return a function of the library of effects."""
    if name in _LIBRARY:
        return getattr(importlib.import_module("ident.dynamics.effects.library"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def translated(tree: ast.Module, path: Path) -> ast.Module:
    """Redirect imports of earlier modules in the syntax `tree` of the effect file `path`.

    Raises:
        BadInput: the file imports a module or a name that no longer exists.
    """
    changed: ast.Module = ast.fix_missing_locations(_Imports(path).visit(tree))
    return changed


class _Imports(ast.NodeTransformer):
    def __init__(self, path: Path) -> None:
        self._path = path

    def visit_ImportFrom(self, node: ast.ImportFrom) -> list[ast.stmt]:
        """`from ident.view import View`, `from ident import view`."""
        if node.level or not node.module or node.module.split(".")[0] != "ident":
            return [node]
        return [ast.copy_location(self._from(node.module, alias), node) for alias in node.names]

    def _from(self, module: str, alias: ast.alias) -> ast.stmt:
        name = f"{module}.{alias.name}"
        submodule = _present(name)
        if submodule:
            return ast.Import([ast.alias(submodule, alias.asname or alias.name)])
        self._check_exists(module)
        present = _present(module) or module
        if present == __name__ and alias.name not in ("*", *_LIBRARY, *globals()):
            raise self._gone(name)
        return ast.ImportFrom(present, [alias], 0)

    def visit_Import(self, node: ast.Import) -> list[ast.stmt]:
        """`import ident.view`, `import ident.view as v`."""
        return [ast.copy_location(self._import(alias), node) for alias in node.names]

    def _import(self, alias: ast.alias) -> ast.stmt:
        if alias.name.split(".")[0] == "ident":
            self._check_exists(alias.name)
        present = _present(alias.name)
        return ast.Import([ast.alias(present, alias.asname or _variable(alias.name)) if present else alias])

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        """`ident.view.View` after `import ident.view`."""
        name = ast.unparse(node)
        if name.startswith("ident.") and _present(name):
            return ast.copy_location(ast.Name(_variable(name), node.ctx), node)
        return self.generic_visit(node)

    def _check_exists(self, module: str) -> None:
        if not _present(module) and not _exists(module):
            raise self._gone(module)

    def _gone(self, name: str) -> BadInput:
        return BadInput(
            f"effect file {self._path}: imports of what docs/how-to/your-own-effect.md lists expected, {name} found, "
            "which does not exist (any longer); change the file"
        )


def _present(module: str) -> str | None:
    """Return the present module with the contents of the earlier `module`; None if it is no earlier module."""
    if module in _COLLECTED:
        return __name__
    for earlier, present in _MOVED.items():
        moved = present + module.removeprefix(earlier)
        if f"{module}.".startswith(f"{earlier}.") and _exists(moved):
            return moved
    return None


def _exists(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except ModuleNotFoundError:
        return False


def _variable(module: str) -> str:
    return "_" + module.replace(".", "_")
