"""`python -m benchmarks.hidden_effects [--plant foreign] [--part chosen] [--cases N] [--stage score] ...`."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click

from benchmarks.hidden_effects import diagnosing, recording, sources, tables, work
from benchmarks.hidden_effects.cases import HiddenCase, Part, PlantName
from benchmarks.hidden_effects.figures import figures
from benchmarks.hidden_effects.parts import PARTS, cases
from benchmarks.hidden_effects.scoring import ScoredCase, judge

FOLDERS: dict[PlantName, Path] = {"simulated": Path("runs/hidden_effects"), "foreign": Path("runs/foreign")}
STAGES = ("record", "diagnose", "score")


@click.command()
@click.option("--plant", type=click.Choice(list(FOLDERS)), default="simulated", show_default=True)
@click.option("--part", type=click.Choice(PARTS), default="tuned", show_default=True, help="Part to run.")
@click.option("--lock", metavar="DIGEST", help="What the locked part is drawn from.  [default: the commit]")
@click.option("--only", multiple=True, metavar="WORD", help="Only cases whose names contain one of these.")
@click.option("--cases", "count", type=click.IntRange(1), metavar="N", help="Only the first N cases of each part.")
@click.option(
    "--stage", "stages", multiple=True, type=click.Choice(STAGES), help="Only these stages.  [default: all]"
)
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Number of parallel processes.")
@click.option(
    "--strict",
    is_flag=True,
    help="Exit code 1 if a required figure is clearly missed, the locked part's excepted.",
)
@click.option("--folder", type=click.Path(path_type=Path), help="Folder of the recordings.  [default: in runs/]")
def main(
    plant: PlantName,
    part: Part,
    lock: str | None,
    only: tuple[str, ...],
    count: int | None,
    stages: tuple[str, ...],
    jobs: int,
    strict: bool,
    folder: Path | None,
) -> None:
    """Hide effects, record, diagnose blind, score all parts. Finished cases are not repeated; Ctrl-C stops."""
    if plant == "simulated" and part != "tuned":
        raise click.UsageError(f"the simulated rig has the tuned part only; for the {part} part use --plant foreign")
    root = folder or FOLDERS[plant]
    answers = work.Answers(root)
    digest = lock or sources.commit()

    def select(part: Part) -> list[HiddenCase]:
        return [case for case in cases(plant, part, digest) if _is_selected(case, only)][:count]

    selected = select(part)
    stages = stages or STAGES
    with work.interruptible():
        if "record" in stages:
            recording.record_missing(selected, root, jobs)
        if "diagnose" in stages:
            engine = diagnosing.engine()
            task = partial(diagnosing.diagnose, root=root, engine=engine)
            answers.completed(engine, _recorded(selected, root), task, jobs, diagnosing.summary)
    if "score" in stages:
        _score(select, root, answers, digest, strict)


def _is_selected(case: HiddenCase, only: Sequence[str]) -> bool:
    return not only or any(word in case.name for word in only)


def _score(
    select: Callable[[Part], list[HiddenCase]], root: Path, answers: work.Answers, digest: str, strict: bool
) -> None:
    engine = answers.last_engine()
    diagnoses = answers.of(engine) if engine else {}
    judged = {part: _judged(select(part), root, diagnoses) for part in PARTS}
    parts = {part: judgements for part, judgements in judged.items() if judgements}
    if not parts:
        raise SystemExit("nothing has been diagnosed yet")
    impossible = sum(not recording.is_possible(case, root) for part in PARTS for case in select(part))
    click.echo(f"ident {engine}; the locked part is drawn from {digest}")
    click.echo(f"{impossible} further cases are impossible: the effect cannot have that size on that robot")
    for line in tables.lines(parts):
        click.echo(line)
    deciding = [figure for part in parts if part != "locked" for figure in figures(parts[part])]
    missed = [figure.criterion.strip() for figure in deciding if figure.clearly_missed]
    if strict and missed:
        raise SystemExit(f"clearly missed: {', '.join(missed)}")


def _judged(
    selected: Sequence[HiddenCase], root: Path, diagnoses: Mapping[str, Mapping[str, Any]]
) -> list[ScoredCase]:
    from drivers.simulated.seal import sealed_path, unseal

    return [
        judge(case, unseal(sealed_path(root / case.name / "train.mcap")), diagnoses[case.name])
        for case in _recorded(selected, root)
        if case.name in diagnoses
    ]


def _recorded(selected: Sequence[HiddenCase], root: Path) -> list[HiddenCase]:
    return [case for case in selected if recording.is_recorded(case, root) and recording.is_possible(case, root)]


main()
