"""`python -m benchmarks.formulas --folder FOLDER [--part chosen] [--cases N] ...`."""

from functools import partial
from pathlib import Path

import click

from benchmarks.formulas import diagnosing, tables
from benchmarks.formulas.cases import cases
from benchmarks.formulas.scoring import score
from benchmarks.hidden_effects import recording, sources, work
from benchmarks.hidden_effects.cases import Kind, Part
from benchmarks.hidden_effects.diagnosing import engine
from benchmarks.hidden_effects.parts import PARTS
from drivers.simulated.seal import sealed_path, unseal
from tests.foreign.pairs import TRAIN


@click.command()
@click.option("--part", type=click.Choice(PARTS), default="tuned", show_default=True, help="Part to run.")
@click.option("--lock", metavar="DIGEST", help="What the locked part is drawn from.  [default: the commit]")
@click.option(
    "--kind",
    "kinds",
    multiple=True,
    type=click.Choice(["outside", "nothing", "single"]),
    default=["outside"],
    show_default=True,
    help="Laws that no effect of the library contains, nothing hidden, or effects of the library. May be repeated.",
)
@click.option(
    "--cases", "count", type=click.IntRange(1, 120), default=60, show_default=True, help="Number of each kind."
)
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Number of parallel processes.")
@click.option("--folder", type=click.Path(path_type=Path), required=True, help="Folder of the recordings.")
def main(part: Part, lock: str | None, kinds: tuple[Kind, ...], count: int, jobs: int, folder: Path) -> None:
    """Hide laws, record, diagnose blind, propose formulas, score. Finished cases are not repeated; Ctrl-C stops."""
    digest = lock or sources.commit()
    selected = [case for kind in kinds for case in cases(kind, part, digest)[:count]]
    recording.record_missing(selected, folder, jobs)
    version = engine()
    possible = [case for case in selected if recording.is_possible(case, folder)]
    task = partial(diagnosing.run, root=folder, engine=version)
    answers = work.Answers(folder)
    diagnosed = answers.completed(version, possible, task, jobs, lambda line: str(line.get("formula", line)))
    truths = [unseal(sealed_path(folder / case.name / TRAIN)) for case in possible]
    scored = [score(case, truth, diagnosed[case.name]) for case, truth in zip(possible, truths, strict=True)]
    click.echo(
        f"ident {version}; part {part} {digest * (part == 'locked')}; {len(selected) - len(scored)} impossible"
    )
    click.echo("\n".join(tables.lines(scored)))


main()
