"""Variants of the diagnosis: a numeric constant halved or doubled.

A constant is a name in capitals at the top of a module of `ident/diagnosis` whose value is a number, or a tuple or
dictionary of numbers, which change together. Its key is its module below that folder and its name. A variant is a
text: `judge.price.PRICE/2` or `judge.price.PRICE*2`.
"""

import ast
import importlib
import re
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import cache
from typing import Any
from unittest.mock import patch

from benchmarks.hidden_effects.sources import ROOT

PACKAGE = "ident.diagnosis"
FACTORS = ("/2", "*2")
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


@cache
def variants() -> tuple[str, ...]:
    """All variants, in the order of the table."""
    keys = [_key(module, name) for module, tree in trees().items() for name in defined(tree)]
    return tuple(key + factor for key in keys for factor in FACTORS)


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
    with ExitStack() as stack:
        for namespace, name, value in list(_assigned(variant[:-2], variant[-2:])):
            stack.enter_context(patch.dict(namespace, {name: value}))
        yield


def _assigned(key: str, factor: str) -> Iterator[tuple[dict[str, Any], str, Any]]:
    """Another value of the constant `key`, and of those that are computed from it, wherever they are known."""
    namespaces = {name: vars(importlib.import_module(name)) for name in trees()}  # all, before any value is another
    home, name = f"{PACKAGE}.{key}".rsplit(".", 1)
    changed = {name: scaled(namespaces[home][name], key, factor)}
    for other, value in defined(trees()[home]).items():
        if any(isinstance(node, ast.Name) and node.id in changed for node in ast.walk(value)):
            code = compile(ast.Expression(value), home, "eval")
            changed[other] = eval(code, namespaces[home] | changed)
    keys = {_key(home, each): new for each, new in changed.items()}
    for module, tree in trees().items():
        names = local_names(module, tree)
        yield from ((namespaces[module], local, keys[each]) for local, each in names.items() if each in keys)
