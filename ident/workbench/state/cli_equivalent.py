"""Terminal commands equivalent to the actions on the page."""

import shlex

from ident.basics.model_name import model_stem
from ident.workbench.worker.views import StepsView
from recordings.command_line import repeated


def shell_script(made: StepsView, model: str) -> str:
    """Return a shell script that writes the current model to the file `model`."""
    lines = [
        "#!/bin/sh",
        "set -eu",
        _command_line("ident", *_model_command(made, _recordings(made)), "-o", model),
        _command_line("ident", "compare", model, made.validate or made.train),
        _command_line(*report_command(made, model, f"{model_stem(model)}.report.html")),
    ]
    return "\n".join(lines) + "\n"


def report_command(made: StepsView, model: str, out: str) -> list[str]:
    """Return the command that writes an HTML report of the model in the file `model` to `out`."""
    return ["ident", "report", model, *_recordings(made), "-o", out]


def swarm_command(made: StepsView | None, train: str, validate: str | None, seed: str, stem: str) -> tuple[str, ...]:
    """Return the words of the command that fits the model of `made`, or the base model, by particle swarm.

    stem: begin of the names of the model and of the folder of pictures that it writes.
    """
    options = [*(("--validate", validate) if validate else ()), "--seed", seed]
    if made:
        options += ["--cutoff", f"{made.bandwidth:g}", *repeated("--with", effect_options(made))]
        options += repeated("--without", left_out(made))
    return ("ident", "fit", train, *options, "-o", f"{stem}.model.json", "--pictures", f"{stem}.pictures")


def torque_command(model: str, path: str, is_recording: bool, out: str, picture: str) -> tuple[str, ...]:
    """Return the words of the command that computes the torque of a trajectory, or of the motion of a recording."""
    return (
        "ident",
        "torque",
        model,
        *((path,) if is_recording else ("--traj", path)),
        "-o",
        out,
        "--picture",
        picture,
    )


def table2_command(train: str | None, validate: str | None, plots: str) -> tuple[str, ...]:
    """Return the words of the command that compares all methods; without two recordings, on the samples."""
    return ("ident", "table2", *((train, validate) if train and validate else ()), "--plots", plots)


def effect_options(made: StepsView) -> tuple[str, ...]:
    """Return the effects of the current model, beyond the base model, as values of `ident fit --with`."""
    return tuple(
        name if len(joints) == len(made.units) else f"{name}:{','.join(map(str, joints))}"
        for name, joints in made.added
    )


def left_out(made: StepsView) -> tuple[str, ...]:
    """Return the mandatory effects that the current model lacks: values of `ident fit --without`."""
    names = {name for name, _ in made.steps[-1].terms}
    return tuple(name for name in made.mandatory if name not in names)


def _recordings(made: StepsView) -> list[str]:
    return [made.train, *(["--validate", made.validate] if made.validate else [])]


def _model_command(made: StepsView, recordings: list[str]) -> list[str]:
    """Return the arguments of `ident diagnose` or `ident fit` that give the current model.

    `ident diagnose` always includes the mandatory effects. A model without one of them, or without added effects, is
    therefore made by `ident fit`.
    """
    if made.findings:
        return ["diagnose", *recordings, "--apply"]
    removed = {name for step in made.steps for name, _ in step.terms} & set(left_out(made))
    if made.added and not removed:
        added = [name for name, _ in made.added]
        return ["diagnose", *recordings, *repeated("--only", added), "--apply"]
    options = repeated("--with", effect_options(made))
    options += repeated("--without", left_out(made))
    return ["fit", *recordings, "--method", "wls", "--cutoff", f"{made.bandwidth:g}", *options]


def _command_line(*words: str) -> str:
    return " ".join(shlex.quote(word) for word in words)
