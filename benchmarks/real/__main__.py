"""`python -m benchmarks.real FOLDER [--only WORD]`: claims about real machines in FOLDER, and how many are right."""

import tempfile
from pathlib import Path

import click

from benchmarks.real import data_set, diagnosing, tables
from recordings.errors import BadInput


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--only", metavar="WORD", default="", help="Only data sets whose names contain this.")
def main(folder: Path, only: str) -> None:
    """Diagnose the data sets in FOLDER, each by its manifest; a data set that is not there is said to be missing."""
    if not folder.is_dir():
        raise SystemExit(f"a folder with data sets expected, {folder} found; see benchmarks/real/data_sets/")
    outcomes = []
    with tempfile.TemporaryDirectory() as scratch:
        for manifest in data_set.manifests():
            if only not in manifest.name:
                continue
            try:
                outcomes.append(diagnosing.diagnose(manifest, folder, Path(scratch)))
            except BadInput as error:
                outcomes.append(diagnosing.DiagnosedSet(manifest, None, str(error)))
            click.echo(f"{manifest.name}: done", err=True)
    for line in tables.lines(outcomes):
        click.echo(line)


if __name__ == "__main__":
    main()
