"""`python -m benchmarks.false_alarms FOLDER [--real DATA]`: count data problems where nothing is wrong.

FOLDER holds the recordings of `python -m benchmarks.hidden_effects`, and DATA the data sets of `benchmarks.real`.
Each recording is examined alone, as by `ident check --problems`.
"""

import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import click

from benchmarks.real import data_set, diagnosing
from ident.data_problems import check_data
from recordings.reader import read


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--cases", "count", type=click.IntRange(1), metavar="N", help="Only the first N cases, by name.")
@click.option("--real", type=click.Path(exists=True, file_okay=False, path_type=Path), metavar="DATA")
def main(folder: Path, count: int | None, real: Path | None) -> None:
    """Count the data problems by kind, and name the recordings that have one."""
    cases = sorted(path.parent for path in folder.glob("*/train.mcap"))[:count]
    report("benchmark", [case / f"{name}.mcap" for case in cases for name in ("train", "validate")])
    if real is not None:
        with tempfile.TemporaryDirectory() as scratch:
            report("real machines", list(real_recordings(real, Path(scratch))))


def real_recordings(folder: Path, scratch: Path) -> Iterator[Path]:
    """Import the data sets in `folder`."""
    for manifest in data_set.manifests():
        train, validate = diagnosing.imported(manifest, folder, scratch)
        yield from (*train, *validate)


def report(what: str, paths: Sequence[Path]) -> None:
    """Examine the recordings `paths`, and print what is said of them."""
    kinds: Counter[str] = Counter()
    for path in paths:
        for problem in check_data([read(path)]).data_problems:
            kinds[problem.kind] += 1
            click.echo(f"  {path.parent.name}/{path.name}: {problem.kind}, {problem.why}")
    counts = ", ".join(f"{number} {kind}" for kind, number in sorted(kinds.items())) or "0 data problems"
    click.echo(f"{what}: {len(paths)} recordings, {counts}")


if __name__ == "__main__":
    main()
