"""Ordinary mistakes on three foreign delta robots that measure their efforts: what is said of them, and where the
remedies lead.

    python -m tests.ident.data_problems.campaign [ROBOT...]

prints a line for each robot and mistake. A test does the same for one robot.
"""

import json
import shlex
import sys
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, get_args
from unittest.mock import patch

from daq.program import program as daq
from ident.program import program as ident
from recordings.reader import read
from tests.foreign import pairs, robots
from tests.ident.conftest import write_recording
from tests.ident.data_problems.test_mistakes import MISTAKES, Mistake
from tests.running import printed

ROBOTS: tuple[robots.Kind, ...] = ("default", "heavy", "light")
Kinds = set[tuple[str, tuple[int, ...]]]
"""Kinds of data problems, with their joints."""
Conclusion = tuple[str, list[tuple[str, list[int]]]]
"""Verdict, and findings with their joints."""


@dataclass(frozen=True)
class Told:
    """What a diagnosis says of two recordings."""

    conclusion: Conclusion
    kinds: Kinds
    remedies: list[list[str]]
    """Words of the commands, without the program."""


def clean(folder: Path, kind: robots.Kind) -> list[Path]:
    """Make two recordings of a robot with a hidden effect, in the existing `folder`."""
    pairs.make(folder, ("stribeck",), (0.04,), 1, pairs.Setting(kind, rate=250.0, signal="effort"))
    return [folder / pairs.TRAIN, folder / pairs.VALIDATE]


def diagnosed(files: Sequence[Path]) -> Told:
    """Diagnose a recording with another one to validate."""
    train, validate = files
    document = json.loads(printed(ident, "diagnose", train, "--validate", validate, "--json"))
    found = document["data_problems"]
    return Told(
        (document["verdict"], sorted((each["effect"], each["joints"]) for each in document["findings"])),
        _kinds(found),
        [shlex.split(each["remedy"])[1:] for each in found if each["remedy"].startswith("daq ")],
    )


def fault(mistake: Mistake, clean_files: Sequence[Path], conclusion: Conclusion, folder: Path) -> str:
    """What is wrong with what is said of a `mistake` in recordings, and with where the remedies lead; nothing where
    all is right.

    conclusion: of the recordings without the mistake; folder: an empty one.
    """
    files = [write_recording(replace(mistake.change(read(file)), path=folder / file.name)) for file in clean_files]
    told, expected = diagnosed(files), {(mistake.kind, mistake.joints)}
    document = json.loads(printed(daq, "import", files[0], "--out", folder / "new.mcap", "--json"))
    imported = _kinds(document["data_problems"])
    if told.kinds != expected or imported != expected:
        return f"diagnose says {sorted(told.kinds)}, import {sorted(imported)}"
    if told.conclusion != (("implausible-data", []) if mistake.blocks else conclusion):
        return f"diagnosed {told.conclusion}"
    if not mistake.remedy.startswith("--"):
        return ""
    with patch("daq.data_problems.of_file", return_value=([], None)):  # the diagnosis looks for itself
        for words in told.remedies:
            printed(daq, *words)
    healed = diagnosed([Path(words[words.index("--out") + 1]) for words in told.remedies]).conclusion
    return "" if healed == conclusion else f"healed {healed}"


def _kinds(found: Sequence[dict[str, Any]]) -> Kinds:
    return {(each["kind"], tuple(each["joints"])) for each in found}


def main(names: Iterable[str]) -> int:
    """Print the results of robots, and return the number of mistakes with which something is wrong."""
    wrong = 0
    for kind in get_args(robots.Kind):
        if kind not in names:
            continue
        with tempfile.TemporaryDirectory() as name:
            files = clean(Path(name), kind)
            conclusion = diagnosed(files).conclusion
            print(f"{kind}: {conclusion}", flush=True)
            for title, mistake in MISTAKES.items():
                with tempfile.TemporaryDirectory() as place:
                    found = fault(mistake, files, conclusion, Path(place))
                wrong += bool(found)
                print(f"{kind}, {title}: {found or 'as it should be'}", flush=True)
    return wrong


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:] or ROBOTS) > 0)
