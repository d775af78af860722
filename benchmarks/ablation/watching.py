"""Watch a diagnosis: which comparisons half or twice a constant would turn.

The modules of the diagnosis are rewritten when they are imported: a comparison, minimum, maximum, clipping or slice
that holds a constant is evaluated three times, with the constant, with half and with twice its value. Where the
result is another, that variant is *near* in this case; where it never is, the comparison changes nothing. Wherever
else a constant is read, such as in a sum that is compared later, it is *used*, and its nearness is not known.
"""

import ast
import sys
from collections.abc import Callable
from copy import deepcopy
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from typing import Any

import numpy as np

from benchmarks.ablation import variants

NEAR: set[str] = set()
"""Variants that change a comparison of this case."""
USED: set[str] = set()
"""Keys of constants whose nearness is not known."""
_FUNCTIONS = ("min", "max", "minimum", "maximum", "clip")
_NOT_MOVED = (ast.NamedExpr, ast.Yield, ast.YieldFrom, ast.Await)
"""What means something else inside of another function."""


def install() -> None:
    """Rewrite the diagnosis, which must not have been imported yet."""
    if not any(isinstance(finder, type) and issubclass(finder, _Finder) for finder in sys.meta_path):
        if variants.PACKAGE in sys.modules:
            raise RuntimeError(f"a process without {variants.PACKAGE} expected: it can be watched no more")
        sys.meta_path.insert(0, _Finder)


class _Finder(PathFinder):
    """Finds the modules of the diagnosis, with a loader that rewrites them."""

    @classmethod
    def find_spec(cls, fullname: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        if fullname not in variants.trees():
            return None
        spec = super().find_spec(fullname, path, target)
        if spec and spec.origin:
            spec.loader = _Loader(fullname, spec.origin)
        return spec


class _Loader(SourceFileLoader):
    def get_code(self, fullname: str) -> Any:
        path = self.get_filename(fullname)
        return compile(rewritten(fullname, ast.parse(self.get_data(path))), path, "exec")

    def exec_module(self, module: Any) -> None:
        vars(module).update(_watch=watch, _use=use)
        super().exec_module(module)


def rewritten(module: str, tree: ast.Module) -> ast.Module:
    """The `tree` of a module, whose functions call `watch` and `use` where they read constants."""
    rewriter = _Rewriter(variants.local_names(module, tree))
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            rewriter.visit(node)
    return ast.fix_missing_locations(tree)


class _Rewriter(ast.NodeTransformer):
    def __init__(self, names: dict[str, str]) -> None:
        self._names = names

    def visit_Name(self, node: ast.Name) -> ast.expr:
        if node.id not in self._names or not isinstance(node.ctx, ast.Load):
            return node
        return ast.Call(ast.Name("_use", ast.Load()), [ast.Constant(self._names[node.id]), node], [])

    def visit_JoinedStr(self, node: ast.JoinedStr) -> ast.JoinedStr:
        return node  # a text decides nothing

    def visit_Compare(self, node: ast.Compare) -> ast.AST:
        return self._watched(node, self._constants(node))

    def visit_Call(self, node: ast.Call) -> ast.AST:
        function = ast.unparse(node.func).rsplit(".", 1)[-1]
        return self._watched(node, self._constants(node) if function in _FUNCTIONS else [])

    def visit_Subscript(self, node: ast.Subscript) -> ast.AST:
        return self._watched(node, self._constants(node.slice) if isinstance(node.ctx, ast.Load) else [])

    def _constants(self, node: ast.AST) -> list[str]:
        return sorted({each.id for each in ast.walk(node) if isinstance(each, ast.Name) and each.id in self._names})

    def _watched(self, node: ast.expr, constants: list[str]) -> ast.AST:
        """A call of `watch` with `node` as a function of its `constants` and of its parts that hold none."""
        body = deepcopy(node)
        moved = self._take_parts(body) if constants else {}
        if not constants or any(isinstance(each, _NOT_MOVED) for each in ast.walk(body)):
            return self.generic_visit(node)
        arguments = [ast.arg(name) for name in (*constants, *moved)]
        function = ast.Lambda(ast.arguments([], arguments, None, [], [], None, []), body)
        keys = ast.Tuple([ast.Constant(self._names[name]) for name in constants], ast.Load())
        read = [ast.Name(name, ast.Load()) for name in constants]
        return ast.Call(ast.Name("_watch", ast.Load()), [keys, function, *read, *moved.values()], [])

    def _take_parts(self, node: ast.expr) -> dict[str, ast.expr]:
        """Replace the operands of `node` without constants by names; they are evaluated once."""
        moved: dict[str, ast.expr] = {}

        def taken(part: ast.expr) -> ast.expr:
            if self._constants(part) or isinstance(part, ast.GeneratorExp | ast.Starred):
                return part
            moved[f"_part_{len(moved)}"] = part
            return ast.Name(f"_part_{len(moved) - 1}", ast.Load())

        match node:
            case ast.Compare(ops=[_]):
                node.left, node.comparators = taken(node.left), [taken(node.comparators[0])]
            case ast.Call():
                node.args = [taken(part) for part in node.args]
            case ast.Subscript():
                node.value = taken(node.value)
        return moved


def watch(keys: tuple[str, ...], function: Callable[..., Any], *values: Any) -> Any:
    """The value of `function`, whose first arguments are the constants `keys`; note where another one changes it."""
    result = function(*values)
    for index, key in enumerate(keys):
        for factor in variants.FACTORS:
            other = [*values[:index], variants.scaled(values[index], key, factor), *values[index + 1 :]]
            if key + factor not in NEAR and not _is_same(result, function, other):
                NEAR.add(key + factor)
    return result


def use(key: str, value: Any) -> Any:
    """The `value` of the constant `key`, which is read outside of any comparison."""
    USED.add(key)
    return value


def _is_same(result: Any, function: Callable[..., Any], values: list[Any]) -> bool:
    try:
        return _equal(result, function(*values))
    except (ArithmeticError, LookupError, TypeError, ValueError):
        return False  # the diagnosis would fail


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(_equal, one, other))
    if isinstance(one, np.ndarray | np.generic | float):
        return one is other or bool(np.array_equal(one, other, equal_nan=np.asarray(one).dtype.kind == "f"))
    return bool(one is other or one == other)
