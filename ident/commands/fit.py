"""`ident fit`: find the parameters of the dynamic model from recordings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ident.basics import plugins
from ident.command_options import (
    ACCEPT,
    CUTOFF,
    EFFECT_FILES,
    FILE,
    RuledCommand,
    again,
    check_choices,
    say_written,
    sets,
    show_result,
)
from recordings.command_line import IntegerRange, NameChoice, check_readable, output_name, refuse_existing, say_next
from recordings.errors import BadInput
from recordings.files import free_name
from recordings.next_command import diagnosis

if TYPE_CHECKING:
    from ident.identification.model import Model
    from ident.uncertainty.covariance import IntervalMethod


@click.command(
    cls=RuledCommand,
    rules=[sets("--paper", "--preprocess", "--cutoff", "--without", unless={"--preprocess": "central"})],
    short_help="Find the parameters of the dynamic model.",
    epilog="Example: ident fit fig5a.mcap --validate fig5b.mcap",
)
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=FILE)
@click.option(
    "--validate",
    type=FILE,
    multiple=True,
    metavar="FILE",
    help="Validate the model on a recording that the fit does not use; may be repeated.",
)
@click.option(
    "--method",
    type=NameChoice(plugins.names("ident.estimation.estimators")),
    help="Estimator.  [default: pso; of a URDF: wls]",
)
@click.option(
    "--preprocess",
    type=NameChoice(plugins.names("ident.data.preprocessing")),
    help="central: central differences of raw angles, as in the paper; parallel: the same low-pass on torque and "
    "regressor; savgol: Savitzky-Golay; fourier: one Fourier series of all cycles; cycle_average: of the mean cycle."
    "  [default: parallel]",
)
@CUTOFF
@click.option(
    "--set",
    "settings",
    metavar="NAME=VALUE",
    multiple=True,
    help="Change a setting of the method (see ident methods), such as iterations=100. May be repeated.",
)
@click.option(
    "--paper",
    is_flag=True,
    help="Proceed as in the paper: the bare model, central differences on all rows, and all 1000 iterations of the "
    "swarm, which --set iterations=50 shortens for a trial. Otherwise the swarm stops at the certified minimum.",
)
@click.option(
    "--with",
    "effects",
    metavar="EFFECT",
    multiple=True,
    help="Add an effect (see ident effects) to the base model, on all joints or, as NAME:1,3, on some. May be "
    "repeated.",
)
@click.option(
    "--without",
    metavar="EFFECT",
    multiple=True,
    help="Leave out an effect of the base model, which every real machine has: rod_inertia. May be repeated.",
)
@EFFECT_FILES
@ACCEPT
@click.option("--physical", is_flag=True, help="Allow only friction that opposes motion.")
@click.option(
    "--intervals",
    type=NameChoice(["stationary", "hac", "cycles"]),
    default="stationary",
    show_default=True,
    help="Estimate of the noise autocovariance: from its spectrum; Newey-West; differences between repetitions.",
)
@click.option("--seed", type=IntegerRange(min=0), default=0, show_default=True, help="Seed of all random numbers.")
@click.option("-o", "--out", type=FILE, metavar="FILE", help="Model file.  [default: first FILE's name, .model.json]")
@click.option(
    "--pictures",
    type=FILE,
    metavar="DIR",
    help="Folder for pictures of torque and convergence.",
)
@click.option("--details", is_flag=True, help="Print parameters, Eq. (41), the assessment and tables of errors.")
@click.option("--force", is_flag=True, help="Replace an existing model, and pictures.")
@click.option("--json", "as_json", is_flag=True, help="Print the model as one JSON document instead of tables.")
def command(
    files: tuple[Path, ...],
    validate: tuple[Path, ...],
    method: str | None,
    preprocess: str | None,
    cutoff: float | None,
    settings: tuple[str, ...],
    paper: bool,
    effects: tuple[str, ...],
    without: tuple[str, ...],
    effect_files: tuple[Path, ...],
    accept: tuple[str, ...],
    physical: bool,
    intervals: IntervalMethod,
    seed: int,
    out: Path | None,
    pictures: Path | None,
    details: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Find the parameters of the dynamic model, Eq. (26), from recordings of one rig.

    Writes the model beside the first recording. Prints the error of each joint, the noise floor, and
    what comes next; with --details everything that is known of the parameters.
    """
    inputs = [*files, *validate]
    check_readable(*inputs)
    method = "pso" if paper and method is None else method
    given = _settings(method, settings, paper)
    check_choices((*effects, *without), effect_files, accept)
    out = output_name(out, files[0].with_suffix(".model.json"), force)
    if out.suffix != ".json":
        raise BadInput(f"-o: a model's name (.model.json) expected, {out} found; give it that ending")
    refuse_existing(out, pictures, force=force, read=inputs)

    import ident
    from recordings.progress import progress_bar

    with progress_bar("reading") as show:
        model = ident.fit(
            files,
            validate=validate,
            method=method,
            effects=effects,
            without=without,
            bare=paper,
            effect_files=effect_files,
            accept=accept,
            preprocessing=preprocess or ("central" if paper else "parallel"),
            cutoff=cutoff,
            physical=physical,
            intervals=intervals,
            seed=seed,
            settings=given,
            progress=lambda done, total, *_: show("fitting", done, total),
        )
    out = out if force else free_name(out)  # another run may have taken the name meanwhile
    _write(model, out, pictures)
    _show(model, as_json, details)
    say_written(model=out, pictures=pictures)
    repeated = again("--validate", "--effect-file", "--accept")
    test = model.file.residual_test
    if effects and test and test.verdict == "within-noise":  # nothing is missing beside what was chosen
        say_next("ident", "report", out, *files, *repeated)
    else:
        say_next(*diagnosis(files, *repeated, model=out))


def _settings(method: str | None, texts: tuple[str, ...], paper: bool) -> dict[str, object]:
    """Settings of the `method` by name: those of the `paper`, unless --set says otherwise; BadInput: one is not."""
    from ident.estimation import estimators
    from ident.estimation.settings import parse

    given: dict[str, object] = dict(parse(texts))
    if paper and method and estimators.has_setting(method, "tolerance"):
        given.setdefault("tolerance", 0.0)
    estimators.settings(method or "pso", given)
    return given


def _show(model: Model, as_json: bool, details: bool) -> None:
    from ident.output.console import fit as console

    found = model.identification
    assert found is not None
    show_result(
        as_json,
        lambda: {**model.file.as_json(), "where": console.sentences(model.file, found)},
        lambda screen: console.show(model.file, found, screen, details),
    )


def _write(model: Model, out: Path, pictures: Path | None) -> None:
    """Write the model, and `pictures` if they are asked for; or nothing."""
    try:
        if pictures is None:
            model.save(out, force=True)
        else:
            from ident.output.pictures import draw, staged_folder

            assert model.identification is not None
            with staged_folder(pictures) as folder:
                draw(model.identification, folder)
                model.save(out, force=True)
    except OSError as error:
        raise BadInput(f"{error.filename or out} cannot be written: {error.strerror}; choose another place") from None
