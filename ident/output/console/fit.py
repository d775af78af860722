"""Print a fit: parameters, agreement per joint, and where the model fails."""

from collections.abc import Iterator, Mapping, Sequence
from math import isinf

from rich.console import Console
from rich.table import Table

from ident.diagnosis.unknown.residual_test import score
from ident.dynamics.effects.base import is_infinite
from ident.dynamics.structure import ModelStructure
from ident.identification.goodness_of_fit import GoodnessOfFit
from ident.identification.identify import Identification
from ident.identification.model_file import Agreement, ModelFile
from ident.output.console import assessment
from ident.residuals.phases import JointResidual, joint_residuals
from recordings.recording import Floats

_RELATIVE = "Torque gain assumed"


def show(model: ModelFile, result: Identification, console: Console, details: bool = False) -> None:
    """Print the error of each joint, the verdict and the worst joint; with `details`, all that is known.

    model: that of the `result`, with the test of its residual.
    """
    for line in warnings(result) if details else short_warnings(result):
        console.print(line, style="bold yellow", highlight=False)
    if details:
        _show_details(model, result, console)
    console.print(_error_table(model, _evaluated(model, result)))
    for sentence in sentences(model, result):
        console.print(sentence, highlight=False)


def _show_details(model: ModelFile, result: Identification, console: Console) -> None:
    console.print(_parameter_table(model))
    for line in (*shape_parameter_lines(result.structure, result.x), *_method_lines(model)):
        console.print(line, highlight=False)
    console.print(_agreement_table(model))
    assessment.show(model, console)
    if model.preprocessing.cutoff:
        console.print(f"Low-pass: {model.preprocessing.cutoff}.", highlight=False)
    if model.preprocessing.delays and within_noise(model):
        delays = ", ".join(map(str, model.preprocessing.delays))
        console.print(f"Delay of the torque behind the reported motion: {delays}; not compensated.", highlight=False)


def within_noise(model: ModelFile) -> bool:
    """Whether nothing structured is left. Otherwise a delay may be a sign of another effect."""
    return model.residual_test is not None and model.residual_test.verdict == "within-noise"


def _evaluated(model: ModelFile, result: Identification) -> dict[str, tuple[JointResidual, ...]]:
    """Residual of each joint by the role of the data, in the rows that are scored."""
    predictions = result.predictions
    if model.form is None:
        predictions = score(predictions, result.structure, result.parameters, model.residual_test)
    count = len(result.train)
    roles = {"training": predictions[:count], "held out": predictions[count:]}
    return {role: joint_residuals(group) for role, group in roles.items() if group}


def _error_table(model: ModelFile, evaluated: Mapping[str, Sequence[JointResidual]]) -> Table:
    unit = ", ".join(dict.fromkeys(model.effort_units))
    effects = f" with {', '.join(model.effects)}" if model.effects else ""
    table = Table(
        title=f"RMS residual [{unit}]{effects}, up to {model.preprocessing.bandwidth:g} Hz",
        title_justify="left",
        box=None,
    )
    table.add_column("")
    for joint in model.joints:
        table.add_column(joint, justify="right")
    for role, joints in evaluated.items():
        table.add_row(role, *(f"{joint.rms:.3g} ({100 * joint.share:.1f} %)" for joint in joints))
    if model.residual_test and None not in model.residual_test.noise_rms:
        table.add_row("noise floor", *(f"{noise:.3g}" for noise in model.residual_test.noise_rms))
    return table


def sentences(model: ModelFile, result: Identification) -> list[str]:
    """The verdict of the test, and the worst joint if the residual is not within the noise."""
    *_, joints = _evaluated(model, result).values()
    verdict = [model.residual_test.sentence] if model.residual_test else []
    if within_noise(model):
        return verdict
    worst = max(joints, key=lambda joint: joint.share)
    return [*verdict, f"Worst: joint {worst.number}, {100 * worst.share:.1f} % of the torque."]


def short_warnings(result: Identification) -> list[str]:
    """Those of the `warnings` that concern the data, in one line each."""
    return [line for line in warnings(result) if line.startswith(("SIMULATED", "Interrupted", _RELATIVE))]


def warnings(result: Identification) -> list[str]:
    """List what limits the meaning of the numbers: simulated or incomplete data, relative torque, bounds."""
    model = result.model
    agreements = [model.train, *([model.validate_] if model.validate_ else [])]
    simulated = [source.name for agreement in agreements for source in agreement.recordings if source.simulated]
    regressions = [*result.train, *([result.validation] if result.validation else [])]
    recordings = [regression.prepared.recording for regression in regressions]
    incomplete = [recording.path.name for recording in recordings if not recording.complete]
    at_bound = [parameter.name for parameter in model.parameters if parameter.at_bound]
    lines = []
    if simulated:
        lines.append(f"SIMULATED data: {', '.join(simulated)}.")
    if incomplete:
        lines.append(f"Interrupted recording, used up to its end: {', '.join(incomplete)}.")
    if model.relative:
        lines.append(f"{_RELATIVE}: the parameters are RELATIVE, known up to a common factor.")
    if model.geometry and model.geometry.L2_source == "assumed":
        lines.append(
            f"The forearm length L2 = {model.geometry.L2:g} m is assumed{assessment.length_sensitivity(model)}."
        )
    lines += _out_of_range(result)
    if at_bound:
        lines.append(f"At a bound of the search range, so not determined by the data: {', '.join(at_bound)}.")
    return lines


def _out_of_range(result: Identification) -> Iterator[str]:
    """Yield the fitted coefficients of effects that are outside of their physical range."""
    entries = [entry for entry in result.structure.parameters if entry.linear]
    for entry, value in zip(entries, result.fit.parameters, strict=True):
        if entry.term >= 0 and not entry.lower <= value <= entry.upper:
            yield (
                f"{entry.name} = {value:.4g} {entry.unit} is outside of its physical range "
                f"({_range(entry.lower, entry.upper)}): evidence against {entry.name.partition('.')[0]}."
            )


def _range(lower: float, upper: float) -> str:
    if isinf(upper):
        return f"at least {lower:g}"
    return f"at most {upper:g}" if isinf(lower) else f"{lower:g} to {upper:g}"


def _parameter_table(model: ModelFile) -> Table:
    label = ", relative" if model.relative else ""
    of_paper = model.mechanism == "delta" and model.form is None
    equation = " of Eq. (26)" if of_paper and not model.effects else " of Eq. (38)" if model.form else ""
    table = Table(title=f"Parameters{equation}{label}", title_justify="left")
    table.add_column("")
    table.add_column("value", justify="right")
    if model.assessment:
        table.add_column("± 95 %", justify="right")
    table.add_column("unit")
    if of_paper:
        table.add_column("as in (36)", justify="right")
    table.add_column("at bound")
    for parameter in model.all_parameters:
        values = [
            _format_value(parameter.value),
            *([assessment.half_width(parameter)] if model.assessment else []),
            parameter.unit,
        ]
        values += [_format_value(parameter.paper_value)] if of_paper else []
        table.add_row(parameter.name, *values, "yes" if parameter.at_bound else "")
    if model.form is None:
        table.caption = "Friction is positive where it opposes motion"
        table.caption += "; (36) has the opposite sign." if of_paper else "."
    return table


def shape_parameter_lines(structure: ModelStructure, x: Floats) -> Iterator[str]:
    """Yield the values of the shape parameters in `x` (K,), which a search has fixed before the linear fit."""
    values = [
        f"{entry.name} {'never' if is_infinite(value, entry.unit) else f'= {value:.4g} {entry.unit}'.rstrip()}"
        for entry, value in zip(structure.parameters, x.tolist(), strict=True)
        if not entry.linear
    ]
    if values:
        yield f"Found by a search before the fit, without intervals: {', '.join(values)}."


def _method_lines(model: ModelFile) -> Iterator[str]:
    """Yield the estimator's diagnostics: certificate, iterations, rank."""
    method, proof = model.method, model.method.certified
    if proof:
        yield (
            f"Objective (33): {method.objective:.7g} {model.effort_units[0]}, at most {proof.excess:.1e} (relative) "
            "above its certified minimum."
        )
    steps = method.diagnostics.get("iterations")
    if steps is not None and steps < method.settings["iterations"]:
        yield f"The swarm stopped after {steps} of {method.settings['iterations']} iterations."
    if "rank" in method.diagnostics:
        yield f"Rank {method.diagnostics['rank']} of {len(model.parameters)}."


def _format_value(value: float) -> str:
    return f"{value:.4f}" if abs(value) >= 0.1 else f"{value:.4g}"


def _agreement_table(model: ModelFile) -> Table:
    compared = "fitted model" if model.train.nominal is None else "fitted model | Table 1 in Eq. (1)"
    table = Table(title=f"Agreement with the measured torque: {compared}", title_justify="left")
    table.add_column("data")
    table.add_column("joint")
    units = ", ".join(dict.fromkeys(model.effort_units))
    for measure in ("Eq. (41)", f"RMS [{units}]", "R²"):
        table.add_column(measure, justify="right")
    agreements: list[tuple[str, Agreement | None]] = [("training", model.train), ("validation", model.validate_)]
    for name, agreement in agreements:
        if agreement:
            for joint in range(len(model.joints)):
                table.add_row(name if joint == 0 else "", str(joint + 1), *_agreement_cells(agreement, joint))
            table.add_section()
    return table


def _agreement_cells(agreement: Agreement, joint: int) -> list[str]:
    fitted, nominal = agreement.fitted, agreement.nominal
    cells = _measures(fitted, joint)
    if nominal is None:
        return cells
    return [f"{cell} | {nominal_cell}" for cell, nominal_cell in zip(cells, _measures(nominal, joint), strict=True)]


def _measures(fitness: GoodnessOfFit, joint: int) -> list[str]:
    return [f"{fitness.nrmse[joint]:.4f}", f"{fitness.rms[joint]:.3f}", f"{fitness.r2[joint]:.4f}"]
