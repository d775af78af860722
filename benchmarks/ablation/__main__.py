"""`python -m benchmarks.ablation [--cases N] [--hours H]`: which constants the verdicts need."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import click

from benchmarks.ablation import subjects, variants
from benchmarks.ablation.results import Results
from benchmarks.ablation.subjects import Pair, Subject, Trial
from benchmarks.hidden_effects import recording, work
from benchmarks.hidden_effects.parts import cases
from benchmarks.hidden_effects.sources import digest

RESULTS = Path("benchmarks/ablation")
"""Folder of the results, one file for each version of the diagnosis."""


@click.command()
@click.option(
    "--cases", "count", type=click.IntRange(0), default=300, show_default=True, help="Of the part `chosen`."
)
@click.option("--traps", type=click.IntRange(0), default=20, show_default=True, help="Traps of each kind.")
@click.option(
    "--data", type=click.Path(path_type=Path), default="../shared/data", show_default=True, help="Real data sets."
)
@click.option(
    "--hours", default=3.0, show_default=True, help="Processor hours for pairs, those in the file included."
)
@click.option("--seed", default=1, show_default=True, help="Order of the pairs.")
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Number of parallel processes.")
@click.option(
    "--folder", type=click.Path(path_type=Path), default="runs/foreign", show_default=True, help="Of the recordings."
)
def main(count: int, traps: int, data: Path, hours: float, seed: int, jobs: int, folder: Path) -> None:
    """Watch the diagnosis of all cases, then diagnose pairs of case and variant that can matter; print a table.

    Variants are half or twice a constant of `ident/diagnosis`. Cases are the first of the part `chosen`, traps, and
    real machines. What is done is not repeated: the same command
    continues. Ctrl-C stops.
    """
    version = digest([variants.PACKAGE.replace(".", "/")])
    results = Results(RESULTS / f"{version}.tsv", version, variants.variants())
    with work.interruptible():
        every = [*_robots(count, folder, jobs), *_traps(traps), *_machines(data)]
        todo = [Pair(subject) for subject in every if subject.name not in results.today]
        for trial in work.run_all(subjects.watch, todo, jobs, "watch", _summary):
            results.add(trial)
        _try(results, every, seed, jobs, hours)
    _print(results, every, seed)


def _robots(count: int, folder: Path, jobs: int) -> list[Subject]:
    """The first `count` cases of the part `chosen` that are possible, recorded into the `folder`."""
    every = cases("foreign", "chosen")[:count]
    recording.record_missing(every, folder, jobs)
    return [
        Subject(case.name, partial(subjects.robot, case, folder))
        for case in every
        if recording.is_possible(case, folder)
    ]


def _traps(count: int) -> list[Subject]:
    from tests.foreign.traps import KINDS

    return [
        Subject(f"trap-{kind}-{seed}", partial(subjects.trap, kind, seed)) for seed in range(count) for kind in KINDS
    ]


def _machines(data: Path) -> list[Subject]:
    from benchmarks.real import data_set

    found: list[Subject] = []
    for manifest in data_set.manifests():
        if all((data / part.path).exists() for part in manifest.parts):
            found.append(Subject(f"real-{manifest.name}", partial(subjects.machine, manifest, data)))
        else:
            click.echo(f"{manifest.name}: not in {data}, left out")
    return found


def _try(results: Results, every: Sequence[Subject], seed: int, jobs: int, hours: float) -> None:
    """Try pairs until none is left, or until all of them together took so many `hours`."""
    if results.seconds > 3600 * hours:
        return
    trials = work.run_all(subjects.try_, results.todo(every, seed), jobs, f"{hours:g} h: try", _summary)
    for trial in trials:
        results.add(trial)
        if results.seconds > 3600 * hours:
            trials.close()
            return


def _summary(trial: Trial) -> str:
    return f"{trial.outcome.text} ({trial.outcome.score}, {trial.seconds:.1f} s)"


def _print(results: Results, every: Sequence[Subject], seed: int) -> None:
    for line in results.table(seed):
        click.echo(line)
    left = len(results.todo(every, seed))
    click.echo(
        f"seed {seed}: {len(results.today)} cases, {len(results.tried)} pairs tried in {results.seconds / 3600:.2f} "
        f"processor hours, {left} not tried"
    )


main()
