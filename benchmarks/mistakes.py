"""`python -m benchmarks.mistakes [FOLDER] [--only WORD]`: ordinary mistakes in recordings of three foreign delta robots.

Each mistake is made in both recordings of a robot that measures its efforts and has a hidden Stribeck effect. Counted is
how often it is named by kind and joint by `ident diagnose` and by `daq import`, and how often the remedies, pasted, lead
to what the diagnosis says of the clean recordings.
"""

import json
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from daq.program import program as daq
from ident.cli import program as ident
from recordings.data_problems import DataProblem
from recordings.reader import read
from tests.foreign import pairs, robots
from tests.ident.conftest import write_recording
from tests.ident.data_problems.test_mistakes import MISTAKES, Mistake
from tests.running import printed

ROBOTS: tuple[robots.Kind, ...] = ("default", "heavy", "light")
FILES = (pairs.TRAIN, pairs.VALIDATE)


@click.command()
@click.argument("folder", type=click.Path(path_type=Path), required=False)
@click.option("--only", metavar="WORD", default="", help="Only mistakes whose names contain this.")
def main(folder: Path | None, only: str) -> None:
    """Make all mistakes on all robots, in FOLDER if it is named, and print what was said of each."""
    counts: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as scratch:
        for seed, kind in enumerate(ROBOTS):
            place = (folder or Path(scratch)) / kind
            for outcome in of_robot(place, kind, seed, only):
                click.echo(outcome)
                counts.update(outcome.split(": ")[1].split(", "))
    for what, count in counts.items():
        click.echo(f"{count} {what}")


def of_robot(folder: Path, kind: robots.Kind, seed: int, only: str) -> Iterator[str]:
    """Make the mistakes on one robot; yield what was said of each."""
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / pairs.VALIDATE).exists():
        pairs.make(folder, ("stribeck",), (0.1,), seed, pairs.Setting(kind, signal="effort"))
    clean = diagnosed(folder, FILES)
    for name, mistake in MISTAKES.items():
        if only in name:
            place = folder / name.replace(" ", "-")
            place.mkdir()
            yield f"{kind}, {name}: {', '.join(said(folder, place, mistake, clean))}"


def said(source: Path, place: Path, mistake: Mistake, clean: dict[str, Any]) -> Iterator[str]:
    """Make a `mistake` in the recordings of `source`, in the folder `place`; yield what was right about the answers."""
    for file in FILES:
        write_recording(replace(mistake.change(read(source / file)), path=place / file))
    document = diagnosed(place, FILES)
    found = [DataProblem.model_validate(each, strict=False) for each in document["data_problems"]]
    named = all((each.kind, each.joints, each.blocks) == expected(mistake) for each in found) and len(found) == len(
        FILES
    )
    empty = (document["verdict"], document["findings"]) == ("implausible-data", [])
    yield "named by diagnose" if named and empty == mistake.blocks else f"diagnose says {document['verdict']} {found}"
    words = ["import", place / pairs.TRAIN, "--out", place / "imported.mcap", "--json"]
    listed = [
        (each["kind"], tuple(each["joints"]), each["blocks"])
        for each in json.loads(printed(daq, *words))["data_problems"]
    ]
    yield "named by import" if listed == [expected(mistake)] else f"import says {listed}"
    if not mistake.remedy.startswith("--"):
        return
    for each in found:
        printed(daq, *(each.command or [])[1:])
    healed = diagnosed(place, [f"{Path(file).stem}-healed.mcap" for file in FILES])
    yield (
        "healed"
        if verdict(healed) == verdict(clean)
        else f"healed says {verdict(healed)} in place of {verdict(clean)}"
    )


def expected(mistake: Mistake) -> tuple[str, tuple[int, ...], bool]:
    """What is to be said of a `mistake`."""
    return mistake.kind, mistake.joints, mistake.blocks


def diagnosed(folder: Path, files: tuple[str, ...] | list[str]) -> dict[str, Any]:
    """The document of a diagnosis of two `files`."""
    train, validate = (folder / file for file in files)
    document: dict[str, Any] = json.loads(printed(ident, "diagnose", train, "--validate", validate, "--json"))
    return document


def verdict(document: dict[str, Any]) -> tuple[str, list[tuple[str, list[int]]]]:
    """Verdict and findings."""
    return document["verdict"], sorted((each["effect"], each["joints"]) for each in document["findings"])


if __name__ == "__main__":
    main()
