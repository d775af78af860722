"""Print what each step of `.ci/run` took, and which tests are unsteady: `python -m tests.machinery.budget FOLDER`."""

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from tests.machinery.hand_over import Finished
from tests.machinery.second_look import VERDICT, finished

STEPS = "steps.tsv"
"""File in the folder: name, wall, user and system seconds of each step."""


def table(steps: Sequence[tuple[str, float, float]], runs: Sequence[Finished]) -> Iterator[str]:
    """Lines for steps (name, wall seconds, CPU seconds) and the runs of pytest in them."""
    total = sum(wall for _, wall, _ in steps)
    yield f"{'step':<28}{'wall s':>8}{'CPU s':>8}{'tests':>8}{'skipped':>9}{'of all':>8}"
    for name, wall, cpu in (*steps, ("in all", total, sum(cpu for *_, cpu in steps))):
        inside = [run for run in runs if run.step == name or name == "in all"]
        tests, skipped = sum(run.passed + run.failed for run in inside), sum(run.skipped for run in inside)
        counted = f"{tests:>8}{skipped:>9}" if inside else f"{'':>17}"
        yield f"{name:<28}{wall:>8.0f}{cpu:>8.0f}{counted}{wall / total if total else 0:>8.0%}"
    for share in dict.fromkeys(run.share for run in runs if not run.share.startswith("1/1 ")):
        part, digest = share.split()
        yield f"slow tests: share {part} drawn by {digest}; again: make test-slow SHARE={part} DRAW={digest}"


def read_steps(folder: Path) -> list[tuple[str, float, float]]:
    """Name, wall and CPU seconds of each step."""
    lines = [line.split("\t") for line in (folder / STEPS).read_text().splitlines()]
    return [(name, float(wall), float(user) + float(system)) for name, wall, user, system in lines]


if __name__ == "__main__":
    _folder = Path(sys.argv[1])
    print(*table(read_steps(_folder), finished(_folder)), sep="\n")
    if (_folder / VERDICT).exists():
        print((_folder / VERDICT).read_text(), end="")
