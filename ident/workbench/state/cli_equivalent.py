"""Terminal commands equivalent to the actions on the page."""

import shlex

from ident.basics.model_name import model_stem
from ident.workbench.worker.views import StepsView, SwarmRequest
from recordings.command_line import repeated


def shell_script(step_list: StepsView, model: str) -> str:
    """Return a shell script that writes the current model to the file `model`."""
    lines = [
        "#!/bin/sh",
        "set -eu",
        _command_line("ident", *_model_command(step_list, _recordings(step_list)), "-o", model),
        _command_line("ident", "compare", model, step_list.validate or step_list.train),
        _command_line(*report_command(step_list, model)),
    ]
    return "\n".join(lines) + "\n"


def report_command(step_list: StepsView, model: str) -> list[str]:
    """Return the command that writes an HTML report of the model in the file `model`."""
    out = f"{model_stem(model)}.report.html"
    return ["ident", "report", model, *_recordings(step_list), "-o", out]


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


def torque_command(model: str, path: str, is_recording: bool, out: str, picture: str) -> tuple[str, ...]:
    """Return the words of the command that computes the torque of a trajectory, or of the motion of a recording."""
    return ("torque", model, *((path,) if is_recording else ("--traj", path)), "-o", out, "--picture", picture)


def table2_command(train: str | None, validate: str | None, plots: str) -> tuple[str, ...]:
    """Return the words of the command that compares all methods; without two recordings, on the samples."""
    return ("table2", *((train, validate) if train and validate else ()), "--plots", plots)


def effect_options(step_list: StepsView) -> tuple[str, ...]:
    """Return the effects of the current model, beyond the base model, as values of `ident fit --with`."""
    return tuple(
        name if len(joints) == len(step_list.units) else f"{name}:{','.join(map(str, joints))}"
        for name, joints in step_list.added
    )


def left_out(step_list: StepsView) -> tuple[str, ...]:
    """Return the mandatory effects that the current model lacks: values of `ident fit --without`."""
    names = {name for name, _ in step_list.steps[-1].terms}
    return tuple(name for name in step_list.mandatory if name not in names)


def _recordings(step_list: StepsView) -> list[str]:
    return [step_list.train, *(["--validate", step_list.validate] if step_list.validate else [])]


def _model_command(step_list: StepsView, recordings: list[str]) -> list[str]:
    """Return the arguments of `ident diagnose` or `ident fit` that give the current model.

    `ident diagnose` always includes the mandatory effects. A model without one of them, or without added effects, is
    therefore made by `ident fit`.
    """
    if step_list.diagnosed:
        return ["diagnose", *recordings, "--apply"]
    removed = {name for step in step_list.steps for name, _ in step.terms} & set(left_out(step_list))
    if step_list.added and not removed:
        added = [name for name, _ in step_list.added]
        return ["diagnose", *recordings, *repeated("--only", added), "--apply"]
    options = repeated("--with", effect_options(step_list))
    options += repeated("--without", left_out(step_list))
    return ["fit", *recordings, "--method", "wls", "--cutoff", f"{step_list.bandwidth:g}", *options]


def _command_line(*words: str) -> str:
    return " ".join(shlex.quote(word) for word in words)
