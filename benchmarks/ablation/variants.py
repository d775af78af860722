"""Variants of the diagnosis: a rule of the judge off, a numeric constant halved or doubled.

A constant is a name in capitals at the top of a module of `ident/diagnosis` whose value is a number, or a tuple or
dictionary of numbers, which change together. Its key is its module below that folder and its name. A variant is a text:
`judge.price.PRICE/2`, `judge.price.PRICE*2` or `rule reach off`.
"""

import ast
import importlib
import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from benchmarks.hidden_effects.sources import ROOT

PACKAGE = "ident.diagnosis"
FACTORS = ("/2", "*2")
_RULES = "judge/rules"
_CAPITALS = re.compile("_?[A-Z][A-Z0-9_]*")
_LEVEL = "LEVEL"
"""End of the names of probabilities near 1: their distance from 1 is halved or doubled."""


@cache
def trees() -> dict[str, ast.Module]:
    """The modules of the diagnosis by name, parsed."""
    folder = ROOT / PACKAGE.replace(".", "/")
    paths = [path for path in sorted(folder.rglob("*.py")) if path.name != "__init__.py"]
    names = (".".join(path.relative_to(ROOT).with_suffix("").parts) for path in paths)
    return {name: ast.parse(path.read_bytes()) for name, path in zip(names, paths, strict=True)}


def defined(tree: ast.Module) -> dict[str, ast.expr]:
    """Numeric constants of a module, and the expressions of their values."""
    found = {}
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            (target,) = node.targets if isinstance(node, ast.Assign) else [node.target]
            if isinstance(target, ast.Name) and _CAPITALS.fullmatch(target.id) and _is_number(node.value):
                found[target.id] = node.value
    return found


def _is_number(node: ast.expr) -> bool:
    match node:
        case ast.Constant(value=value):
            return type(value) in (int, float)
        case ast.UnaryOp(operand=operand):
            return _is_number(operand)
        case ast.BinOp(left=left, right=right):
            return all(_is_number(side) or isinstance(side, ast.Name) for side in (left, right))
        case ast.Tuple(elts=[_, *_] as parts) | ast.Dict(values=[_, *_] as parts):
            return all(map(_is_number, parts))
    return False


@cache
def local_names(module: str, tree: ast.Module) -> dict[str, str]:
    """Names by which a `module` knows constants, its own and imported ones, with their keys."""
    names = {name: _key(module, name) for name in defined(tree)}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module in trees():
            known = local_names(node.module, trees()[node.module])
            names |= {alias.asname or alias.name: known[alias.name] for alias in node.names if alias.name in known}
    return names


def _key(module: str, name: str) -> str:
    return f"{module.removeprefix(PACKAGE + '.')}.{name}"


def captured() -> list[str]:
    """Keys of constants in default values or class bodies, which take them when they are defined, with the module."""
    return [
        f"{names[node.id]} in {module}"
        for module, tree in trees().items()
        if (names := local_names(module, tree))
        for holder in ast.walk(tree)
        for part in _evaluated_once(holder)
        for node in ast.walk(part)
        if isinstance(node, ast.Name) and node.id in names
    ]


def _evaluated_once(holder: ast.AST) -> list[ast.expr]:
    match holder:
        case ast.FunctionDef(args=arguments) | ast.Lambda(args=arguments):
            return [*arguments.defaults, *filter(None, arguments.kw_defaults)]
        case ast.ClassDef(body=body):
            return [each.value for each in body if isinstance(each, ast.Assign | ast.AnnAssign) and each.value]
    return []


@cache
def variants() -> tuple[str, ...]:
    """All variants, in the order of the table."""
    keys = [_key(module, name) for module, tree in trees().items() for name in defined(tree)]
    folder = ROOT / PACKAGE.replace(".", "/") / _RULES
    rules = sorted(path.stem for path in folder.glob("*.py") if path.stem != "__init__")
    return (*(f"rule {rule} off" for rule in rules), *(key + factor for key in keys for factor in FACTORS))


def rules() -> list[dict[str, Any]]:
    """The dictionaries of the judge's rules."""
    module = importlib.import_module(f"{PACKAGE}.{_RULES.replace('/', '.')}")
    return [module.OF_VALUES, module.OF_INTERVALS]


def scaled(value: Any, key: str, factor: str) -> Any:
    """Half or twice the `value` of a constant; a whole number stays one, and at least 1."""
    ratio = 0.5 if factor == "/2" else 2.0
    match value:
        case tuple():
            return tuple(scaled(each, key, factor) for each in value)
        case dict():
            return {name: scaled(each, key, factor) for name, each in value.items()}
        case int():
            return max(1, round(value * ratio))
    return 1 - (1 - value) / ratio if key.endswith(_LEVEL) else value * ratio


@contextmanager
def applied(variant: str) -> Iterator[None]:
    """Let the diagnosis be the `variant` of itself."""
    modules = {name: importlib.import_module(name) for name in trees()}  # all, before any value is another
    holders = [vars(module) for module in modules.values()] + rules()
    before = [dict(holder) for holder in holders]
    try:
        if variant.startswith("rule "):
            for dictionary in rules():
                dictionary.pop(variant.split()[1], None)
        else:
            _assign(variant[:-2], variant[-2:], {name: vars(module) for name, module in modules.items()})
        yield
    finally:
        for holder, old in zip(holders, before, strict=True):
            holder.clear()
            holder.update(old)


def _assign(key: str, factor: str, namespaces: dict[str, dict[str, Any]]) -> None:
    """Set the constant `key`, and those that are computed from it, wherever they are known."""
    home, name = f"{PACKAGE}.{key}".rsplit(".", 1)
    changed = {name: scaled(namespaces[home][name], key, factor)}
    for other, value in defined(trees()[home]).items():
        if any(isinstance(node, ast.Name) and node.id in changed for node in ast.walk(value)):
            code = compile(ast.Expression(value), home, "eval")
            changed[other] = eval(code, namespaces[home] | changed)
    keys = {_key(home, each): new for each, new in changed.items()}
    for module, tree in trees().items():
        names = local_names(module, tree)
        namespaces[module].update({local: keys[each] for local, each in names.items() if each in keys})
