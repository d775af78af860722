"""Terminal commands equivalent to the actions on the page."""

import shlex

from ident.model_name import model_stem
from ident.workbench.views import LadderView, SwarmRequest
from recordings.command_line import repeated


def shell_script(ladder: LadderView, model: str) -> str:
    """Return a shell script that writes the current model to the file `model`."""
    lines = [
        "#!/bin/sh",
        "set -eu",
        _command_line("ident", *_model_command(ladder, _recordings(ladder)), "-o", model),
        _command_line("ident", "compare", model, ladder.validate or ladder.train),
        _command_line(*report_command(ladder, model)),
    ]
    return "\n".join(lines) + "\n"


def report_command(ladder: LadderView, model: str) -> list[str]:
    """Return the command that writes an HTML report of the model in the file `model`."""
    out = f"{model_stem(model)}.report.html"
    return ["ident", "report", model, *_recordings(ladder), "-o", out]


def swarm_command(request: SwarmRequest, train: str, validate: str | None) -> str:
    """Return the command that fits the same parameters by particle swarm."""
    options = [
        *(("--validate", validate) if validate else ()),
        *(("--cutoff", f"{request.cutoff:g}") if request.cutoff else ()),
        *repeated("--with", request.effects),
        *repeated("--without", request.without),
        *(("--seed", str(request.seed)) if request.seed else ()),
    ]
    return _command_line("ident", "fit", train, *options)


def effect_options(ladder: LadderView) -> tuple[str, ...]:
    """Return the effects of the current model, beyond the base model, as values of `ident fit --with`."""
    return tuple(
        name if len(joints) == len(ladder.units) else f"{name}:{','.join(map(str, joints))}"
        for name, joints in ladder.steps[-1].terms
        if name not in ladder.mandatory
    )


def left_out(ladder: LadderView) -> tuple[str, ...]:
    """Return the mandatory effects that the current model lacks: values of `ident fit --without`."""
    names = {name for name, _ in ladder.steps[-1].terms}
    return tuple(name for name in ladder.mandatory if name not in names)


def _recordings(ladder: LadderView) -> list[str]:
    return [ladder.train, *(["--validate", ladder.validate] if ladder.validate else [])]


def _model_command(ladder: LadderView, recordings: list[str]) -> list[str]:
    """Return the arguments of `ident diagnose` or `ident fit` that give the current model.

    `ident diagnose` always includes the mandatory effects. A model without one of them, or without added effects, is
    therefore made by `ident fit`.
    """
    names = [name for name, _ in ladder.steps[-1].terms]
    mandatory = {name for step in ladder.steps for name, _ in step.terms if name in ladder.mandatory}
    added = [name for name in names if name not in mandatory]
    if ladder.diagnosed:
        return ["diagnose", *recordings, "--apply"]
    if added and mandatory <= set(names):
        return ["diagnose", *recordings, *repeated("--only", added), "--apply"]
    options = repeated("--with", effect_options(ladder))
    options += repeated("--without", left_out(ladder))
    return ["fit", *recordings, "--method", "wls", "--cutoff", f"{ladder.bandwidth:g}", *options]


def _command_line(*words: str) -> str:
    return " ".join(shlex.quote(word) for word in words)
