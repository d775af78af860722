"""The commands that do in a terminal what was done on the page."""

import shlex

from ident.workbench.views import LadderView


def script(ladder: LadderView, model: str) -> str:
    """A shell script that ends with the present model in the file `model`."""
    recordings = [ladder.train, *(["--validate", ladder.validate] if ladder.validate else [])]
    judged = ladder.validate or ladder.train
    lines = [
        "#!/bin/sh",
        "set -eu",
        _line("ident", "diagnose", *recordings, *_steps(ladder), "--apply", "-o", model),
        _line("ident", "compare", model, judged),
    ]
    return "\n".join(lines) + "\n"


def _steps(ladder: LadderView) -> list[str]:
    """Nothing where the program climbed by itself; else what was added by hand."""
    if ladder.diagnosed:
        return []
    names = [name for name, _ in ladder.rungs[-1].terms if name not in ladder.always]
    return [part for name in names for part in ("--only", name)]


def _line(*words: str) -> str:
    return " ".join(shlex.quote(word) for word in words)
