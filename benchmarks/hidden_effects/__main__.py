"""`python -m benchmarks.hidden_effects [--plant foreign] [--only WORD] [--cases N] [--stage score] ...`."""

import signal
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import click

from benchmarks.hidden_effects import diagnosing, recording, tables, work
from benchmarks.hidden_effects.cases import Case, cases
from benchmarks.hidden_effects.scoring import judge

FOLDERS = {"simulated": Path("runs/hidden_effects"), "foreign": Path("runs/foreign")}
STAGES = ("record", "diagnose", "score")


@click.command()
@click.option("--plant", type=click.Choice(list(FOLDERS)), default="simulated", show_default=True)
@click.option("--only", multiple=True, metavar="WORD", help="Only cases whose names contain one of these.")
@click.option("--cases", "count", type=click.IntRange(1), metavar="N", help="Only the first N cases.")
@click.option(
    "--stage", "stages", multiple=True, type=click.Choice(STAGES), help="Only these stages.  [default: all]"
)
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Number of parallel processes.")
@click.option("--strict", is_flag=True, help="Exit code 1 if a required figure is clearly missed.")
@click.option("--folder", type=click.Path(path_type=Path), help="Folder of the recordings.  [default: in runs/]")
def main(
    plant: str,
    only: tuple[str, ...],
    count: int | None,
    stages: tuple[str, ...],
    jobs: int,
    strict: bool,
    folder: Path | None,
) -> None:
    """Hide effects, record, diagnose blind, score. Finished cases are not repeated; Ctrl-C stops."""
    root = folder or FOLDERS[plant]
    root.mkdir(parents=True, exist_ok=True)
    selected = [case for case in cases("foreign" if plant == "foreign" else "simulated") if _is_selected(case, only)][
        :count
    ]
    stages = stages or STAGES
    # A shell makes background processes ignore Ctrl-C.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    try:
        if "record" in stages:
            _record(selected, root, jobs)
        if "diagnose" in stages:
            _diagnose(selected, root, jobs)
    except KeyboardInterrupt:
        click.echo("stopped; the same command continues", err=True)
        raise SystemExit(1) from None
    if "score" in stages:
        _score(selected, root, strict)


def _is_selected(case: Case, only: Sequence[str]) -> bool:
    return not only or any(word in case.name for word in only)


def _record(selected: Sequence[Case], root: Path, jobs: int) -> None:
    todo = [case for case in selected if not recording.is_recorded(case, root)]
    for _ in work.run_all(partial(recording.record, root=root), todo, jobs, "record"):
        pass


def _diagnose(selected: Sequence[Case], root: Path, jobs: int) -> None:
    engine, answers = diagnosing.engine(), diagnosing.Answers(root)
    diagnosed = answers.of(engine)
    todo = [case for case in _recorded(selected, root) if case.name not in diagnosed]
    task = partial(diagnosing.diagnose, root=root, engine=engine)
    for line in work.run_all(task, todo, jobs, "diagnose", diagnosing.summary):
        answers.append(line)


def _score(selected: Sequence[Case], root: Path, strict: bool) -> None:
    from drivers.simulated.seal import sealed_path, unseal

    answers = diagnosing.Answers(root)
    engine = answers.last_engine()
    diagnoses = answers.of(engine) if engine else {}
    judgements = [
        judge(case, unseal(sealed_path(root / case.name / "train.mcap")), diagnoses[case.name])
        for case in _recorded(selected, root)
        if case.name in diagnoses
    ]
    if not judgements:
        raise SystemExit("nothing has been diagnosed yet")
    impossible = sum(not recording.is_possible(case, root) for case in selected if recording.is_recorded(case, root))
    click.echo(
        f"ident {engine}; {impossible} further cases are impossible: the effect cannot have that size on that robot"
    )
    for line in tables.lines(judgements):
        click.echo(line)
    missed = [figure.criterion.strip() for figure in tables.figures(judgements) if figure.clearly_missed]
    if strict and missed:
        raise SystemExit(f"clearly missed: {', '.join(missed)}")


def _recorded(selected: Sequence[Case], root: Path) -> list[Case]:
    return [case for case in selected if recording.is_recorded(case, root) and recording.is_possible(case, root)]


main()
