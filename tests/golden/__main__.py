"""`python -m tests.golden keep|compare [--only NAME] [--relative 1e-9] [--code FOLDER]`."""

import json
import platform
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import click

from tests.golden.cases import CASES, HERE, Case, Code, CommandFailed, Documents, documents
from tests.golden.differences import Comparison, compare, shortened

KEPT = Path(__file__).parent / "kept"
MADE_WITH = KEPT / "made_with.json"
_LIBRARIES = ("numpy", "scipy", "numba")
_MAX_PRINTED = 5
"""Number of differences that are printed for each document."""
_SAME_AS = {"model": "fit"}
"""Documents that are not stored, because they must equal another document."""


@click.command()
@click.argument("action", type=click.Choice(["keep", "compare"]))
@click.option(
    "--only", multiple=True, type=click.Choice([case.name for case in CASES]), help="Only this case; may be repeated."
)
@click.option("--relative", default=1e-9, show_default=True, help="Relative tolerance of numbers.")
@click.option("--jobs", type=click.IntRange(1), default=2, show_default=True, help="Number of parallel processes.")
@click.option(
    "--code",
    type=click.Path(path_type=Path, exists=True),
    default=HERE,
    help="Another checkout whose commands are run.",
)
def main(action: str, only: tuple[str, ...], relative: float, jobs: int, code: Path) -> None:
    """Run the commands; store their documents or compare them with the stored ones."""
    selected = [case for case in CASES if not only or case.name in only]
    if action == "compare" and (environment := _made_with()) != (
        stored_environment := json.loads(MADE_WITH.read_text(encoding="utf-8"))
    ):
        click.echo(f"stored with {stored_environment}, here {environment}: last digits may differ", err=True)
    differs = False
    for case, actual in _run_all(selected, Code(code.resolve()), jobs):
        if isinstance(actual, CommandFailed):
            click.echo(f"{case.name}: {actual}")
            differs = True
        elif action == "keep":
            _keep(case, actual)
        else:
            differs |= _compare(case, actual, relative)
    if action == "keep":
        MADE_WITH.write_text(json.dumps(_made_with(), indent=1) + "\n", encoding="utf-8")
    sys.exit(differs)


def _run_all(selected: Sequence[Case], code: Code, jobs: int) -> Iterator[tuple[Case, Documents | CommandFailed]]:
    """Yield each case with its documents, in the order of the list."""
    code.record(selected, jobs)
    with ThreadPoolExecutor(jobs) as pool:
        yield from zip(selected, pool.map(partial(_documents, code=code), selected), strict=True)


def _documents(case: Case, code: Code) -> Documents | CommandFailed:
    try:
        with tempfile.TemporaryDirectory() as folder:
            return documents(case, code, Path(folder))
    except CommandFailed as error:
        return error


def _keep(case: Case, actual: Documents) -> None:
    """Store the documents of a case, one line each, so that a changed document is one changed line."""
    lines = [f"{json.dumps(name)}: {_dumped(actual[name])}" for name in actual if name not in _SAME_AS]
    path = KEPT / f"{case.name}.json"
    path.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    click.echo(f"{case.name}: {path.stat().st_size / 1e3:.0f} kB kept")


def _dumped(document: Any) -> str:
    return json.dumps(shortened(document), ensure_ascii=False, separators=(",", ":"))


def _compare(case: Case, actual: Documents, relative: float) -> bool:
    """Print how each document compares; return whether any differs."""
    kept = json.loads((KEPT / f"{case.name}.json").read_text(encoding="utf-8"))
    kept |= {name: kept[source] for name, source in _SAME_AS.items()}
    differences = [compare(kept[name], shortened(actual[name]), relative) for name in actual]
    for name, comparison in zip(actual, differences, strict=True):
        click.echo(_report(f"{case.name} {name}", comparison))
    return any(comparison.differences for comparison in differences)


def _report(name: str, comparison: Comparison) -> str:
    count = len(comparison.differences)
    verdict = f"{count} difference{'s' * (count > 1)}" if count else "equal"
    lines = [f"{name}: {verdict}, worst relative difference {comparison.worst:.2g}"]
    lines += [f"    {difference}" for difference in comparison.differences[:_MAX_PRINTED]]
    if count > _MAX_PRINTED:
        lines.append(f"    and {count - _MAX_PRINTED} more")
    return "\n".join(lines)


def _made_with() -> dict[str, str]:
    """Processor and versions, which the last digits depend on."""
    return {"processor": platform.machine(), "python": platform.python_version()} | {
        library: version(library) for library in _LIBRARIES
    }


main()
