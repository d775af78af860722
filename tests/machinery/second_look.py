"""Run what failed once more, alone: `python -m tests.machinery.second_look FOLDER`.

A test that passes then is unsteady: it is named and fails nothing, and is mended or removed in the next change (see
`unsteady.toml`). Safety, a module that is not collected, a crashed process and more than five failures are never
excused. Exit code: 0 or 1.
"""

import json
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from tests.machinery.hand_over import BEGUN, FAILED, KINDS, RUNS, SECOND_LOOK, Failure, Finished

VERDICT = "verdict.txt"
"""File in the folder: what was said."""
MOST = 5
"""Failures that may be looked at again: more are no accident."""
_ROOT = Path(__file__).parents[2]


def failures(folder: Path) -> list[Failure]:
    """All that was handed to the folder, and to those below it; of one test the most serious failure."""
    found = [Failure(**json.loads(line)) for line in _lines(folder, FAILED)]
    return list({each.test: each for each in sorted(found, key=lambda each: KINDS.index(each.kind))}.values())


def finished(folder: Path) -> list[Finished]:
    """The runs of pytest that ended."""
    return [Finished(**json.loads(line)) for line in _lines(folder, RUNS)]


def _lines(folder: Path, name: str) -> list[str]:
    return [line for path in sorted(folder.rglob(name)) for line in path.read_text().splitlines()]


def verdict(failed: Sequence[Failure], passes: Callable[[Failure], bool]) -> tuple[bool, list[str]]:
    """Whether the run is good, and the lines that say why. `passes` runs a test once more."""
    final = [failure for failure in failed if failure.kind not in SECOND_LOOK]
    if final:
        return False, [f"not looked at again ({failure.kind}): {failure.test}" for failure in final]
    if len(failed) > MOST:
        return False, [f"{len(failed)} tests failed; at most {MOST} are looked at again"]
    passed = {failure.test: passes(failure) for failure in failed}
    lines = [f"{'unsteady' if good else 'failed twice'}: {test}" for test, good in passed.items()]
    return all(passed.values()), lines


def passes(failure: Failure) -> bool:
    """Whether a test passes, alone. One that is skipped does not, unless it came late before and the
    machine does not keep time any more."""
    test = failure.test
    with tempfile.TemporaryDirectory() as folder:
        handed = ["-q", f"--hand-to={folder}"]
        if test.startswith("tests/vcan/"):
            command = ["tests/vcan/run", folder, *handed, test]
        else:
            command = [sys.executable, "-m", "pytest", *handed, test]
        done = subprocess.run(command, cwd=_ROOT, check=False)
        run = finished(Path(folder))
        ran = bool(run) and run[-1].passed + (failure.kind == "timing") * run[-1].unjudged > 0
        return done.returncode == 0 and ran and run[-1].failed == 0


def main(folder: Path) -> int:
    """Look at what failed; see the module."""
    begun, ended = len(_lines(folder, BEGUN)), len(finished(folder))
    if not 0 < begun == ended:
        good, lines = False, [f"{begun} runs of tests began, {ended} ended"]
    else:
        good, lines = verdict(failures(folder), passes)
    told = "".join(f"{line}\n" for line in lines)
    print(told, end="")
    (folder / VERDICT).write_text(told)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
