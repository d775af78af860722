"""Print a fit: parameters, agreement per joint, and where the model fails."""

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite

from rich.console import Console

from ident.diagnosis.unknown.residual_test import score
from ident.identification.identify import Identification
from ident.identification.model_file import ModelFile
from ident.output import assessment
from ident.output.console.printing import print_plain, print_table, show_problems
from ident.output.tables import ResultTable, parameters
from ident.residuals.phases import JointResidual, joint_residuals

_RELATIVE = "Torque gain assumed"
_UNFINISHED = "The swarm ended"
_ALWAYS = ("SIMULATED", "Interrupted", _RELATIVE, _UNFINISHED)
"""Beginnings of the warnings that are printed without details, too."""
_MAX_EXCESS = 0.01
"""Above the certified minimum, relative, from which on the parameters are others than those of the minimum."""


def show(model: ModelFile, result: Identification, console: Console, details: bool = False) -> None:
    """Print the verdict and the worst joint, then the error of each joint; with `details`, all that is known.

    model: that of the `result`, with the test of its residual.
    """
    show_problems(model.data_problems, console)
    print_plain(console, " ".join(sentences(model, result)), "bold")
    for line in warnings(result):
        if details or line.startswith(_ALWAYS):
            print_plain(console, line, "bold yellow")
    if details:
        _show_details(model, result, console)
    elif model.assessment:
        for sentence in assessment.warning_lines(model.assessment, certain=True):
            print_plain(console, sentence, "bold yellow")
    print_table(console, _error_table(model, _evaluated(model, result)), box=None)


def _show_details(model: ModelFile, result: Identification, console: Console) -> None:
    print_table(console, parameters.fitted(model))
    for line in _method_lines(model):
        print_plain(console, line)
    print_table(console, parameters.agreement(model))
    if model.assessment:
        print_plain(console, "Assessment of the parameters:")
        for line in assessment.summary_lines(model, model.assessment):
            print_plain(console, f"  {line}")
        for table in (parameters.details, parameters.correlations):
            print_table(console, table(model, model.assessment))
    if model.preprocessing.cutoff:
        print_plain(console, f"Low-pass: {model.preprocessing.cutoff}.")
    if model.preprocessing.delays and _within_noise(model):
        delays = ", ".join(map(str, model.preprocessing.delays))
        print_plain(console, f"Delay of the torque behind the reported motion: {delays}; not compensated.")


def _within_noise(model: ModelFile) -> bool:
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


def _error_table(model: ModelFile, evaluated: Mapping[str, Sequence[JointResidual]]) -> ResultTable:
    rows = [
        (role, *(f"{joint.rms:.3g} ({100 * joint.share:.1f} %)" for joint in joints))
        for role, joints in evaluated.items()
    ]
    if model.residual_test and None not in model.residual_test.noise_rms:
        rows.append(("noise floor", *(f"{noise:.3g}" for noise in model.residual_test.noise_rms)))
    unit = ", ".join(dict.fromkeys(model.effort_units))
    effects = f" with {', '.join(model.effects)}" if model.effects else ""
    title = f"RMS residual [{unit}], {model.method.name}{effects}, up to {model.preprocessing.bandwidth:g} Hz"
    return ResultTable(("", *model.joints), rows, title=title)


def sentences(model: ModelFile, result: Identification) -> list[str]:
    """The verdict of the test, and the worst joint if the residual is not within the noise."""
    *_, joints = _evaluated(model, result).values()
    verdict = [model.residual_test.sentence] if model.residual_test else []
    if _within_noise(model):
        return verdict
    worst = max(joints, key=lambda joint: joint.share)
    return [*verdict, f"Worst: joint {worst.number}, {100 * worst.share:.1f} % of the torque."]


def warnings(result: Identification) -> list[str]:
    """List what limits the meaning of the numbers: simulated or incomplete data, relative torque, bounds."""
    model = result.model
    sources = [*model.train.recordings, *(model.validate_.recordings if model.validate_ else ())]
    regressions = (*result.train, *result.validation)
    lines = list(assessment.data_warnings(sources, (each.prepared.recording for each in regressions)))
    if model.relative:
        lines.append(f"{_RELATIVE}: the parameters are RELATIVE, known up to a common factor.")
    if model.geometry and model.geometry.L2_source == "assumed":
        sensitivity = assessment.length_sensitivity(model)
        lines.append(f"The forearm length L2 = {model.geometry.L2:g} m is assumed{sensitivity}.")
    proof = model.method.certified
    if proof and proof.excess > _MAX_EXCESS:
        lines.append(
            f"{_UNFINISHED} too early: its objective is {1 + proof.excess:.3g} times the certified minimum, so these "
            "are not the parameters of the best fit: choose --method lad, or wls."
        )
    lines += _out_of_range(result)
    return lines


def _out_of_range(result: Identification) -> Iterator[str]:
    """Yield the fitted coefficients of effects that are outside of their physical range."""
    entries = [entry for entry in result.structure.parameters if entry.linear]
    for entry, value in zip(entries, result.fit.parameters, strict=True):
        if entry.term >= 0 and not entry.lower <= value <= entry.upper:
            limits = [f"at least {entry.lower:g}"] if isfinite(entry.lower) else []
            limits += [f"at most {entry.upper:g}"] if isfinite(entry.upper) else []
            yield (
                f"{entry.name} = {value:.4g} {entry.unit} is outside of its physical range "
                f"({' and '.join(limits)}): evidence against {entry.name.partition('.')[0]}."
            )


def _method_lines(model: ModelFile) -> Iterator[str]:
    """Yield the estimator's diagnostics: certificate, iterations, rank."""
    method, proof = model.method, model.method.certified
    if proof:
        yield (
            f"Objective (33): {method.objective:.7g} {model.effort_units[0]}, at most {proof.excess:.1e} (relative) "
            "above its certified minimum."
        )
    if method.diagnostics.get("bound_to_bodies"):
        yield "The links are bound to be bodies: so, parts of the training motion tell the others better."
    steps = method.diagnostics.get("iterations")
    if steps is not None and steps < method.settings["iterations"]:
        yield f"The swarm stopped after {steps} of {method.settings['iterations']} iterations."
    if "rank" in method.diagnostics:
        yield f"Rank {method.diagnostics['rank']} of {len(model.parameters)}."
