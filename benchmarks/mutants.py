"""`python -m benchmarks.mutants [--seed 1] [--count 20] [-- PYTEST ARGUMENTS]`: whether fast tests notice wrong code.

Mutants are single changes of the code of a folder: a comparison negated, an operator swapped, a constant halved or
doubled, a branch always or never taken, an argument dropped, a statement deleted. Texts, annotations, progress and
guards against zero are left alone: no test needs to see them. A mutant dies where a test fails, or does not end. The
tests run in a copy of the tree, and finished mutants are not repeated: the same command continues.
"""

import ast
import os
import random
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory

import click

from benchmarks.hidden_effects.sources import ROOT, digest
from benchmarks.hidden_effects.work import Answers

RESULTS = Path("runs/mutants")
FAST = ("-q", "-x", "-p", "no:cacheprovider", "-m", "not slow and not realtime")
PATIENCE = 4.0
"""Tests that take this many times as long as without a mutant do not end."""
_NOT_COPIED = shutil.ignore_patterns(".git", ".venv", "runs", "build")
_PAIRS: tuple[tuple[type[ast.AST], type[ast.AST]], ...] = (
    (ast.Lt, ast.GtE),
    (ast.LtE, ast.Gt),
    (ast.Eq, ast.NotEq),
    (ast.Is, ast.IsNot),
    (ast.In, ast.NotIn),
    (ast.And, ast.Or),
    (ast.Add, ast.Sub),
    (ast.Mult, ast.Div),
    (ast.BitAnd, ast.BitOr),
)
_OPERATORS = {old: new for pair in _PAIRS for old, new in (pair, pair[::-1])}
_FUNCTIONS = {
    old: new
    for pair in (("min", "max"), ("minimum", "maximum"), ("any", "all"), ("argmin", "argmax"))
    for old, new in (pair, pair[::-1])
}
_NO_CODE = ("annotation", "returns", "decorator_list", "bases")
"""Fields of nodes."""
_GUARDS = ("_TINY", "TINY", "_SEED")
_COSMETIC = ("strict", "rcond")
"""Arguments that change nothing while the code is right."""


@dataclass(frozen=True)
class Mutant:
    """One change of one module."""

    number: str
    """Path, line, column, and the index among all mutants of the module: no two mutants have the same."""
    before: str
    after: str

    @property
    def path(self) -> str:
        """Of the module."""
        return self.number.split(":")[0]

    @property
    def index(self) -> int:
        """Among all mutants of the module."""
        return int(self.number.rsplit(":", 1)[1])

    @property
    def text(self) -> str:
        """The change in one line."""
        return f"{self.number}: {_short(self.before)}  ->  {_short(self.after)}"


def mutants_of(path: str, text: str) -> Iterator[Mutant]:
    """Yield each mutant of the module `path` with the source `text`."""
    for index, (place, before, after) in enumerate(_mutations(ast.parse(text))):
        number = f"{path}:{getattr(place, 'lineno', 0)}:{getattr(place, 'col_offset', 0)}:{index}"
        yield Mutant(number, ast.unparse(before), ast.unparse(after))


def source_of(mutant: Mutant, text: str) -> str:
    """Source of the changed module, whose unchanged one is `text`."""
    tree = ast.parse(text)
    next(islice(_mutations(tree), mutant.index, None))
    return ast.unparse(ast.fix_missing_locations(tree))


def _mutations(tree: ast.Module) -> Iterator[tuple[ast.AST, ast.AST, ast.AST]]:
    """Change the `tree` in one place after another, as long as the caller looks: a node with that place, old, new."""
    for parent, field, index, node in _places(tree):
        for changed in _changes(node):
            _put(parent, field, index, changed)
            yield node if hasattr(node, "lineno") else parent, node, changed
            _put(parent, field, index, node)


def draw(folder: str, seed: int, count: int, root: Path = ROOT) -> list[Mutant]:
    """`count` mutants of the modules in `folder`, drawn with `seed`; all, in random order, if there are fewer."""
    paths = sorted((root / folder).rglob("*.py"))
    every = [
        mutant
        for path in paths
        for mutant in mutants_of(str(path.relative_to(root)), path.read_text(encoding="utf-8"))
    ]
    return random.Random(seed).sample(every, min(count, len(every)))


def _places(parent: ast.AST) -> Iterator[tuple[ast.AST, str, int | None, ast.AST]]:
    """Yield where code stands below `parent`: the node that holds it, field, index in a list, and the node."""
    for field, value in ast.iter_fields(parent):
        if field in _NO_CODE:
            continue
        for index, node in enumerate(value if isinstance(value, list) else [value]):
            if isinstance(node, ast.AST) and not _is_text(node):
                yield parent, field, index if isinstance(value, list) else None, node
                yield from _places(node)


def _put(parent: ast.AST, field: str, index: int | None, node: ast.AST) -> None:
    if index is None:
        setattr(parent, field, node)
    else:
        getattr(parent, field)[index] = node


def _is_text(node: ast.AST) -> bool:
    """Whether a change below `node` changes only what is shown, or nothing."""
    match node:
        case ast.Raise() | ast.JoinedStr() | ast.Import() | ast.ImportFrom():
            return True
        case ast.FunctionDef(name=name):
            return name in ("__repr__", "__str__")
        case ast.Expr(value=ast.Constant()):
            return True
        case ast.Expr(value=ast.Call(func=called)):
            return "progress" in ast.unparse(called)
        case ast.Assign(targets=[ast.Name(id=name)], value=value):
            is_type = isinstance(value, ast.Subscript) and name[:1].isupper() and not name.isupper()
            return name in _GUARDS or is_type
        case ast.keyword(arg=name):
            return name in _COSMETIC
    return False


def _changes(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what may stand in the place of `node`."""
    match node:
        case ast.Constant():
            yield from map(ast.Constant, _values(node.value))
        case ast.If() | ast.IfExp():
            tests = ast.UnaryOp(ast.Not(), node.test), ast.Constant(True), ast.Constant(False)
            yield from (_with(node, test=test) for test in tests)
        case ast.comprehension(ifs=[_, *_]):
            yield _with(node, ifs=[])
        case ast.Call():
            yield from _calls(node)
        case ast.AugAssign() | ast.Continue() | ast.Break() | ast.Expr(value=ast.Call()):
            yield ast.Pass()
        case _:
            yield from _operations(node)


def _values(value: object) -> set[bool] | set[int] | set[float]:
    """Values in the place of the constant `value`; none in the place of a text."""
    match value:
        case bool():
            return {not value}
        case int():
            return {2 * value or 1, value // 2} - {value}
        case float():
            return {2 * value, value / 2} - {value}
    return set()


def _operations(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the comparison or operation `node` with the opposite operator, or without its sign."""
    match node:
        case ast.Compare(ops=[operator]) if type(operator) in _OPERATORS:
            yield _with(node, ops=[_OPERATORS[type(operator)]()])
        case ast.BoolOp(op=operator):
            yield _with(node, op=_OPERATORS[type(operator)]())
        case ast.BinOp(op=operator) if type(operator) in _OPERATORS and not _joins_texts(node):
            yield _with(node, op=_OPERATORS[type(operator)]())
        case ast.UnaryOp(op=ast.Not() | ast.Invert() | ast.USub(), operand=operand):
            yield operand


def _joins_texts(node: ast.BinOp) -> bool:
    """Whether one side is a text."""
    sides = node.left, node.right
    return any(
        isinstance(side, ast.JoinedStr) or (isinstance(side, ast.Constant) and isinstance(side.value, str))
        for side in sides
    )


def _calls(node: ast.Call) -> Iterator[ast.AST]:
    """Yield the call with the opposite function, and without each of its arguments by name."""
    name = ast.unparse(node.func)
    *first, last = name.rsplit(".", 1)
    if last in _FUNCTIONS:
        yield _with(node, func=ast.parse(".".join([*first, _FUNCTIONS[last]]), mode="eval").body)
    for keyword in node.keywords:
        if keyword.arg not in (*_COSMETIC, None) and name != "dict":
            yield _with(node, keywords=[each for each in node.keywords if each is not keyword])


def _with(node: ast.AST, **fields: object) -> ast.AST:
    """A shallow copy of `node` with other `fields`."""
    return type(node)(**{**dict(ast.iter_fields(node)), **fields})


def _short(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= 70 else f"{line[:67]}..."


class Tests:
    """The fast tests, in a copy of the tree."""

    def __init__(self, copy: Path, arguments: tuple[str, ...]) -> None:
        self._copy, self._arguments = copy, arguments
        self.limit: float | None = None
        """Longest time that they may take [s]."""
        self.said = ""
        """What pytest printed last."""

    def kill(self, mutant: Mutant) -> bool:
        """Whether any test fails, or does not end, with the `mutant` in place of its module."""
        path = self._copy / mutant.path
        original, stat = path.read_bytes(), path.stat()
        path.write_text(source_of(mutant, original.decode()), encoding="utf-8")
        try:
            return not self.pass_()
        finally:
            path.write_bytes(original)
            os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))  # compiled functions stay valid

    def pass_(self) -> bool:
        """Whether all pass in time."""
        command = [sys.executable, "-m", "pytest", *FAST, *self._arguments]
        environment = {**os.environ, "PYTHONPATH": str(self._copy), "OPENBLAS_NUM_THREADS": "1"}
        try:
            done = subprocess.run(command, cwd=self._copy, env=environment, capture_output=True, timeout=self.limit)
        except subprocess.TimeoutExpired:
            return False
        self.said = done.stdout.decode() + done.stderr.decode()
        if done.returncode not in (0, 1, 2):  # 2: a module cannot be imported
            raise SystemExit(self.said)
        return done.returncode == 0


@click.command()
@click.option("--seed", default=1, show_default=True)
@click.option("--count", default=20, show_default=True, help="Number of mutants.")
@click.option("--folder", default="ident/diagnosis", show_default=True, help="Whose modules are changed.")
@click.option("--list", "only_list", is_flag=True, help="Print the mutants and run nothing.")
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def main(seed: int, count: int, folder: str, only_list: bool, arguments: tuple[str, ...]) -> None:
    """Draw mutants and run the fast tests on each; ARGUMENTS: of pytest, by default the folder's own tests."""
    drawn = draw(folder, seed, count)
    print(f"seed {seed}: {len(drawn)} mutants of {folder}", flush=True)
    if only_list:
        print("\n".join(mutant.text for mutant in drawn))
        return
    tree = digest((folder, "tests"))
    results = Answers(RESULTS)
    killed = {number: line["killed"] for number, line in results.of(tree).items()}
    with TemporaryDirectory() as name:
        copy = Path(name) / "tree"
        shutil.copytree(ROOT, copy, ignore=_NOT_COPIED)
        tests = Tests(copy, arguments or (f"tests/{folder}",))
        _measure(tests)
        for number, mutant in enumerate(drawn, start=1):
            if mutant.number not in killed:
                killed[mutant.number] = tests.kill(mutant)
                line = {"case": mutant.number, "change": mutant.text, "killed": killed[mutant.number]}
                results.append({"engine": tree, **line})
            print(f"{number:3} {'dies ' if killed[mutant.number] else 'LIVES'} {mutant.text}", flush=True)
    print(f"{sum(killed[mutant.number] for mutant in drawn)} of {len(drawn)} die")


def _measure(tests: Tests) -> None:
    """Set the time limit of the `tests`, which must pass without a mutant."""
    start = time.monotonic()
    if not tests.pass_():
        raise SystemExit(f"{tests.said}\nthe tests fail without any mutant")
    tests.limit = PATIENCE * (time.monotonic() - start)
    print(f"the tests pass without a mutant in {tests.limit / PATIENCE:.0f} s", flush=True)


if __name__ == "__main__":
    main()
