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
_SHOWN = 5
"""Paths of a document that differs."""
_SAME_AS = {"model": "fit"}
"""What is not kept, for it is to be the same as another document."""


@click.command()
@click.argument("what", type=click.Choice(["keep", "compare"]))
@click.option("--only", multiple=True, type=click.Choice([case.name for case in CASES]), help="May be repeated.")
@click.option("--relative", default=1e-9, show_default=True, help="How far numbers may be apart.")
@click.option("--jobs", type=click.IntRange(1), default=2, show_default=True, help="Processes side by side.")
@click.option(
    "--code",
    type=click.Path(path_type=Path, exists=True),
    default=HERE,
    help="Another checkout, to run its commands.",
)
def main(what: str, only: tuple[str, ...], relative: float, jobs: int, code: Path) -> None:
    """Run the commands, and keep what they print or compare it with what was kept."""
    chosen = [case for case in CASES if not only or case.name in only]
    if what == "compare" and (here := _made_with()) != (then := json.loads(MADE_WITH.read_text(encoding="utf-8"))):
        click.echo(f"kept with {then}, here {here}: last digits may differ", err=True)
    differs = False
    for case, made in _all(chosen, Code(code.resolve()), jobs):
        if isinstance(made, CommandFailed):
            click.echo(f"{case.name}: {made}")
            differs = True
        elif what == "keep":
            _keep(case, made)
        else:
            differs |= _compare(case, made, relative)
    if what == "keep":
        MADE_WITH.write_text(json.dumps(_made_with(), indent=1) + "\n", encoding="utf-8")
    sys.exit(differs)


def _all(chosen: Sequence[Case], code: Code, jobs: int) -> Iterator[tuple[Case, Documents | CommandFailed]]:
    """Each case with its documents, in the order of the list."""
    code.record(chosen, jobs)
    with ThreadPoolExecutor(jobs) as pool:
        yield from zip(chosen, pool.map(partial(_documents, code=code), chosen), strict=True)


def _documents(case: Case, code: Code) -> Documents | CommandFailed:
    try:
        with tempfile.TemporaryDirectory() as folder:
            return documents(case, code, Path(folder))
    except CommandFailed as error:
        return error


def _keep(case: Case, made: Documents) -> None:
    """One line per document: small, and a change of one is seen as one."""
    lines = [f"{json.dumps(name)}: {_dumped(made[name])}" for name in made if name not in _SAME_AS]
    path = KEPT / f"{case.name}.json"
    path.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
    click.echo(f"{case.name}: {path.stat().st_size / 1e3:.0f} kB kept")


def _dumped(document: Any) -> str:
    return json.dumps(shortened(document), ensure_ascii=False, separators=(",", ":"))


def _compare(case: Case, made: Documents, relative: float) -> bool:
    """Tell how each document compares; returns whether any differs."""
    kept = json.loads((KEPT / f"{case.name}.json").read_text(encoding="utf-8"))
    kept |= {name: kept[same] for name, same in _SAME_AS.items()}
    differences = [compare(kept[name], shortened(made[name]), relative) for name in made]
    for name, comparison in zip(made, differences, strict=True):
        click.echo(_told(f"{case.name} {name}", comparison))
    return any(comparison.differences for comparison in differences)


def _told(name: str, comparison: Comparison) -> str:
    count = len(comparison.differences)
    verdict = f"{count} difference{'s' * (count > 1)}" if count else "equal"
    lines = [f"{name}: {verdict}, worst relative difference {comparison.worst:.2g}"]
    lines += [f"    {difference}" for difference in comparison.differences[:_SHOWN]]
    if count > _SHOWN:
        lines.append(f"    and {count - _SHOWN} more")
    return "\n".join(lines)


def _made_with() -> dict[str, str]:
    """What the last digits depend on."""
    return {"processor": platform.machine(), "python": platform.python_version()} | {
        library: version(library) for library in _LIBRARIES
    }


main()
