"""Print the assessment of a fit: a short summary, or tables with all details."""

from collections.abc import Iterator

import numpy as np
from rich.console import Console
from rich.table import Table

from ident.identification.model_file import FittedParameter, ModelFile
from ident.uncertainty.assessment import Assessment, JointFloor

NOTABLE_CORRELATION = 0.7
"""Absolute correlation from which the summary lists a pair of parameters."""
MAX_PAIRS = 5
"""Number of pairs that the summary lists at most."""


def show(model: ModelFile, console: Console, details: bool) -> None:
    """Print the errors of the parameters of `model`; with `details`, also as tables."""
    if model.trust is None:
        return
    console.print("Assessment of the parameters:")
    for line in summary_lines(model, model.trust):
        console.print(f"  {line}", highlight=False)
    if details:
        console.print(_parameter_table(model, model.trust))
        console.print(_correlation_table(model, model.trust))
        if model.trust.floor:
            console.print(_noise_floor_table(model, model.trust.floor))


def half_width(parameter: FittedParameter) -> str:
    """Half the width of the 95 % interval, to two digits."""
    return "" if parameter.ci95 is None else _two_digits((parameter.ci95[1] - parameter.ci95[0]) / 2)


def length_sensitivity(model: ModelFile) -> str:
    """Change of the parameters when L2 is 10 mm longer, as the end of a sentence."""
    changes = {p.name: p.per_length_step / abs(p.value) for p in model.parameters if p.per_length_step and p.value}
    if not changes:
        return ""
    largest = max(changes, key=lambda name: abs(changes[name]))
    named = dict.fromkeys(["m_p", largest]) if "m_p" in changes else {largest: None}
    return "; 10 mm more change " + " and ".join(f"{name} by {100 * changes[name]:+.2g} %" for name in named)


def summary_lines(model: ModelFile, assessment: Assessment) -> Iterator[str]:
    """Yield the sentences of the summary."""
    yield _interval_line(assessment)
    yield _noise_line(model, assessment)
    yield from _trend_lines(assessment)
    yield _identifiability_line(model, assessment)
    yield from (f"{group.sentence}." for group in assessment.inseparable)
    yield from _correlation_lines(model, assessment)
    yield from (f"Not physical: {violation.sentence}." for violation in assessment.doubts)
    if assessment.coupling:
        warning = "" if assessment.coupling.positive else "; D(θ) is not positive definite: NOT PHYSICAL"
        share = f"{100 * assessment.coupling.share:.0f} % of the total"
        yield f"Inertia coupling between the joints: the off-diagonal part of D(θ), Eq. (27), is {share}{warning}."
    yield from _cutoff_lines(model, assessment)


def _interval_line(assessment: Assessment) -> str:
    sources = {
        "stationary": "noise assumed stationary in volts",
        "hac": "Newey-West",
        "cycles": "differences between repetitions",
    }
    if assessment.gain_uncertainty:
        gain = f"gain uncertainty of {100 * assessment.gain_uncertainty:.2g} % included"
    else:
        gain = "absolute" if assessment.absolute else "known up to the common torque gain: only ratios are determined"
    return (
        f"± is half the 95 % interval of a fit by least {assessment.loss} ({sources[assessment.source]}; "
        f"autocorrelation of the residuals is counted), given model and geometry; {gain}."
    )


def _noise_line(model: ModelFile, assessment: Assessment) -> str:
    unit, drive = model.effort_units[0], assessment.noise[0].unit
    signal = f"{', '.join(_two_digits(joint.volts) for joint in assessment.noise)} {drive}"
    if assessment.floor is None:
        return f"Noise floor: unknown, no cycle is repeated. Noise, from the {assessment.noise[0].source}: {signal}."
    floors = ", ".join(_two_digits(joint.noise_rms) for joint in assessment.floor)
    shares = ", ".join(f"{100 * joint.above_noise:.0f}" for joint in assessment.floor)
    return (
        f"Noise floor from {assessment.floor[0].cycles} repetitions: {floors} {unit} RMS ({signal}); {shares} % of "
        "the residual's mean square is above it."
    )


def _trend_lines(assessment: Assessment) -> Iterator[str]:
    for number, joint in enumerate(assessment.floor or (), start=1):
        if joint.trend:
            yield (
                f"Joint {number}: the residual changes from repetition to repetition ({joint.trend.pattern}, "
                f"p = {joint.trend.p_value:.1g}): check for drift or a change of load."
            )


def _identifiability_line(model: ModelFile, assessment: Assessment) -> str:
    identifiable = [parameter.name for parameter in model.parameters if parameter.status == "identifiable"]
    remaining = {status: [p.name for p in model.parameters if p.status == status] for status in ("weak", "not")}
    labels = {"weak": "only weakly identifiable", "not": "NOT identifiable"}
    exceptions = [f"{labels[status]}: {', '.join(names)}" for status, names in remaining.items() if names]
    subject = (
        "all parameters are" if len(identifiable) == len(model.parameters) else f"{len(identifiable)} parameters are"
    )
    return (
        f"Condition number {assessment.condition_number:.3g}; {'; '.join([f'{subject} identifiable', *exceptions])}."
    )


def _correlation_lines(model: ModelFile, assessment: Assessment) -> Iterator[str]:
    pairs = sorted(
        (
            (rho, model.parameters[i].name, model.parameters[j].name)
            for i, row in enumerate(assessment.correlation)
            for j, rho in enumerate(row[:i])
            if rho is not None and abs(rho) >= NOTABLE_CORRELATION
        ),
        key=lambda pair: -abs(pair[0]),
    )
    if pairs:
        listed = ", ".join(f"{first} and {second} {rho:+.2f}" for rho, first, second in pairs[:MAX_PAIRS])
        suffix = f", and {len(pairs) - MAX_PAIRS} more" if len(pairs) > MAX_PAIRS else ""
        yield f"Strongly correlated errors: {listed}{suffix}."
    yield from _offset_correlation_lines(model, assessment)


def _offset_correlation_lines(model: ModelFile, assessment: Assessment) -> Iterator[str]:
    """Yield the correlation of Coulomb friction and offset per joint: motion in one direction only confounds them."""
    index = {parameter.name: i for i, parameter in enumerate(model.parameters)}
    for name, i in index.items():
        offset = index.get(f"torque_offset.a{name.removeprefix('c_c')}") if name.startswith("c_c") else None
        rho = None if offset is None else assessment.correlation[max(i, offset)][min(i, offset)]
        if rho is not None and offset is not None:
            yield f"Coulomb friction {name} and {model.parameters[offset].name}: errors correlate by {rho:+.2f}."


def _cutoff_lines(model: ModelFile, assessment: Assessment) -> Iterator[str]:
    for i, hz in enumerate(assessment.cutoffs):
        changes = {p.name: p.per_cutoff[i] / p.std for p in model.parameters if p.std}
        if changes:
            largest = max(changes, key=lambda name: abs(changes[name]))
            yield f"At a cut-off of {hz:.3g} Hz, {largest} changes most, by {changes[largest]:+.1f} standard errors."


def _parameter_table(model: ModelFile, assessment: Assessment) -> Table:
    table = Table(title="Parameters in detail", title_justify="left")
    moves = ["L2", *(f"{hz:.3g} Hz" for hz in assessment.cutoffs)]
    for heading in ("", "from", "to", "std. error", "dof", "known", *moves):
        table.add_column(heading, justify="left" if heading in ("", "known") else "right")
    labels = {"identifiable": "yes", "weak": "weakly", "not": "no", None: ""}
    for p in model.parameters:
        ends = ("", "") if p.ci95 is None else (f"{p.ci95[0]:.4g}", f"{p.ci95[1]:.4g}")
        changes = [
            None if p.std is None or move is None else move / p.std for move in (p.per_length_step, *p.per_cutoff)
        ]
        cells = [_optional(p.std, ".2g"), _optional(p.degrees_of_freedom, ".0f"), labels[p.status]]
        table.add_row(p.name, *ends, *cells, *(_optional(change, "+.1f") for change in changes))
    table.caption = (
        "95 % interval; standard error and its degrees of freedom (dof); whether the parameter is identifiable; its "
        "change, in standard errors, with L2 10 mm longer and with other cut-offs."
    )
    return table


def _correlation_table(model: ModelFile, assessment: Assessment) -> Table:
    table = Table(title="Correlation of the errors, in percent", title_justify="left")
    table.add_column("")
    for parameter in model.parameters:
        table.add_column(parameter.name, justify="right")
    for parameter, row in zip(model.parameters, assessment.correlation, strict=True):
        table.add_row(parameter.name, *("" if rho is None else f"{100 * rho:.0f}" for rho in row))
    return table


def _noise_floor_table(model: ModelFile, floor: tuple[JointFloor, ...]) -> Table:
    table = Table(title=f"Residual, RMS [{model.effort_units[0]}]", title_justify="left")
    for heading in ("joint", "repetitions", "total", "noise", "repeatable", "p-value"):
        table.add_column(heading, justify="right")
    for number, joint in enumerate(floor, start=1):
        rms = [f"{np.sqrt(max(square, 0.0)):.3g}" for square in (joint.total, joint.noise, joint.repeating)]
        table.add_row(str(number), str(joint.cycles), *rms, f"p = {joint.repeating_p:.1g}")
    return table


def _optional(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form)


def _two_digits(value: float) -> str:
    """Format `value` with two significant digits, or as a whole number from 100 on."""
    return f"{value:.2g}" if value < 100 else f"{value:.0f}"
