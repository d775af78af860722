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
@click.option("--only", multiple=True, metavar="WORD", help="Only cases whose names hold one of these.")
@click.option("--cases", "count", type=click.IntRange(1), metavar="N", help="Only the first N of them.")
@click.option("--stage", "stages", multiple=True, type=click.Choice(STAGES), help="Only these.  [default: all]")
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Processes side by side.")
@click.option("--strict", is_flag=True, help="Fail where a required figure is missed by more than bad luck.")
@click.option("--folder", type=click.Path(path_type=Path), help="For the recordings.  [default: in runs/]")
def main(
    plant: str,
    only: tuple[str, ...],
    count: int | None,
    stages: tuple[str, ...],
    jobs: int,
    strict: bool,
    folder: Path | None,
) -> None:
    """Hide effects, record, diagnose blind, score. What is done already is not done again; Ctrl-C stops."""
    root = folder or FOLDERS[plant]
    root.mkdir(parents=True, exist_ok=True)
    chosen = [case for case in cases("foreign" if plant == "foreign" else "simulated") if _wanted(case, only)][:count]
    stages = stages or STAGES
    # Also where it runs in the background, where a shell has Ctrl-C ignored.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    try:
        if "record" in stages:
            _record(chosen, root, jobs)
        if "diagnose" in stages:
            _diagnose(chosen, root, jobs)
    except KeyboardInterrupt:
        click.echo("stopped; the same command goes on from here", err=True)
        raise SystemExit(1) from None
    if "score" in stages:
        _score(chosen, root, strict)


def _wanted(case: Case, only: Sequence[str]) -> bool:
    return not only or any(word in case.name for word in only)


def _record(chosen: Sequence[Case], root: Path, jobs: int) -> None:
    todo = [case for case in chosen if not recording.is_recorded(case, root)]
    for _ in work.over(partial(recording.record, root=root), todo, jobs, "record"):
        pass


def _diagnose(chosen: Sequence[Case], root: Path, jobs: int) -> None:
    engine, answers = diagnosing.engine(), diagnosing.Answers(root)
    known = answers.of(engine)
    todo = [case for case in _recorded(chosen, root) if case.name not in known]
    task = partial(diagnosing.diagnose, root=root, engine=engine)
    for line in work.over(task, todo, jobs, "diagnose", diagnosing.word):
        answers.append(line)


def _score(chosen: Sequence[Case], root: Path, strict: bool) -> None:
    from drivers.simulated.seal import sealed_path, unseal

    answers = diagnosing.Answers(root)
    engine = answers.last_engine()
    said = answers.of(engine) if engine else {}
    judged = [
        judge(case, unseal(sealed_path(root / case.name / "train.mcap")), said[case.name])
        for case in _recorded(chosen, root)
        if case.name in said
    ]
    if not judged:
        raise SystemExit("nothing has been diagnosed yet")
    impossible = sum(not recording.is_possible(case, root) for case in chosen if recording.is_recorded(case, root))
    click.echo(f"ident {engine}; {impossible} further cases cannot be had: no such size on that robot")
    for line in tables.lines(judged):
        click.echo(line)
    missed = [figure.what.strip() for figure in tables.figures(judged) if figure.clearly_missed]
    if strict and missed:
        raise SystemExit(f"clearly missed: {', '.join(missed)}")


def _recorded(chosen: Sequence[Case], root: Path) -> list[Case]:
    return [case for case in chosen if recording.is_recorded(case, root) and recording.is_possible(case, root)]


main()
