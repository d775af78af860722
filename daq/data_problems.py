"""What cannot be right about a recording, as the program `ident` says, which is never imported here."""

import json
import subprocess
from pathlib import Path

from daq.ident_program import IDENT
from recordings import data_problems
from recordings.data_problems import DataProblem
from recordings.reader import read

_CHECK = (*IDENT, "check", "--problems", "--json")
_TIMEOUT = 600.0
"""Longest time that the check may take [s]."""


def of_file(path: Path) -> tuple[list[DataProblem], str | None]:
    """The problems of the recording `path`, and why those that take a model were not looked for; None: they were."""
    try:
        done = subprocess.run(
            [*_CHECK, str(path)], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=_TIMEOUT
        )
    except subprocess.TimeoutExpired:
        done = subprocess.CompletedProcess(_CHECK, 1, "", f"no answer within {_TIMEOUT:g} s")
    if done.returncode == 0:
        return [
            DataProblem.model_validate(each, strict=False) for each in json.loads(done.stdout)["data_problems"]
        ], None
    reason = (done.stderr.strip().splitlines() or ["no reason"])[-1].removeprefix("error: ")
    return list(data_problems.problems(read(path))), f"`ident check` cannot look further into it: {reason}"
