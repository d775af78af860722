"""The commands that do in a terminal what was done on the page."""

import shlex

from ident.workbench.views import Chosen, LadderView


def script(ladder: LadderView, model: str) -> str:
    """A shell script that ends with the present model in the file `model`."""
    lines = [
        "#!/bin/sh",
        "set -eu",
        _line("ident", *_fitted(ladder, _recordings(ladder)), "-o", model),
        _line("ident", "compare", model, ladder.validate or ladder.train),
        _line(*report_command(ladder, model)),
    ]
    return "\n".join(lines) + "\n"


def report_command(ladder: LadderView, model: str) -> list[str]:
    """One HTML file about the model in the file `model`."""
    out = model.removesuffix(".json").removesuffix(".model") + ".report.html"
    return ["ident", "report", model, *_recordings(ladder), "-o", out]


def swarm_command(chosen: Chosen, train: str, validate: str | None) -> str:
    """What lets the swarm find the same parameters."""
    words = ["ident", "fit", train, *(["--validate", validate] if validate else [])]
    words += ["--cutoff", f"{chosen.cutoff:g}"] if chosen.cutoff else []
    words += [word for name in chosen.effects for word in ("--with", name)]
    words += ["--seed", str(chosen.seed)] if chosen.seed else []
    return _line(*words)


def of_fit(ladder: LadderView) -> tuple[str, ...]:
    """The effects of the present model, as `ident fit --with` takes them."""
    return tuple(_on(name, joints, len(ladder.joints)) for name, joints in ladder.rungs[-1].terms)


def _recordings(ladder: LadderView) -> list[str]:
    return [ladder.train, *(["--validate", ladder.validate] if ladder.validate else [])]


def _fitted(ladder: LadderView, recordings: list[str]) -> list[str]:
    """As the program climbed by itself, or what was added by hand.

    `ident diagnose` always has what is true of any machine; a model from which that was taken away, or to which
    nothing was added, is one for `ident fit`.
    """
    present = ladder.rungs[-1].terms
    names = [name for name, _ in present]
    true = {name for rung in ladder.rungs for name, _ in rung.terms if name in ladder.always}
    added = [name for name in names if name not in true]
    if ladder.diagnosed:
        return ["diagnose", *recordings, "--apply"]
    if added and true <= set(names):
        return ["diagnose", *recordings, *(part for name in added for part in ("--only", name)), "--apply"]
    effects = [part for one in of_fit(ladder) for part in ("--with", one)]
    return ["fit", *recordings, "--method", "ls", "--cutoff", f"{ladder.bandwidth:g}", *effects]


def _on(name: str, joints: tuple[int, ...], dof: int) -> str:
    return name if len(joints) == dof else f"{name}:{','.join(map(str, joints))}"


def _line(*words: str) -> str:
    return " ".join(shlex.quote(word) for word in words)
