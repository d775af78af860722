"""Sentences on the data and the assessment of a fit, on console and page."""

from collections.abc import Iterable, Iterator

from ident.basics.statistics import NORMAL
from ident.identification.model_file import FittedParameter, ModelFile, RecordingSource
from ident.uncertainty.assessment import Assessment
from recordings.recording import Recording

NOTABLE_CORRELATION = 0.7
"""Absolute correlation from which the summary lists a pair of parameters."""
_SOURCES = {
    "stationary": "noise assumed stationary in volts",
    "hac": "Newey-West",
    "cycles": "differences between repetitions",
}
"""Where the covariance comes from."""
MAX_PAIRS = 5
"""Number of pairs that the summary lists at most."""


def half_width(parameter: FittedParameter) -> float | None:
    """Half the width of the 95 % interval for an exactly known gain; None without an interval."""
    limits = parameter.shape_ci95 or parameter.ci95
    return None if limits is None else (limits[1] - limits[0]) / 2


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
    yield (
        f"± is half the 95 % interval of a fit by least {assessment.loss} ({_SOURCES[assessment.source]}; "
        f"autocorrelation of the residuals is counted), given model, geometry and gain. "
        f"{scale_line(assessment.scale_uncertainty, not assessment.absolute)}"
    )
    yield _noise_line(model, assessment)
    yield from _trend_lines(model, assessment)
    yield _identifiability_line(model, assessment)
    yield from (f"{group.sentence}." for group in assessment.inseparable)
    yield from _correlation_lines(model, assessment)
    yield from warning_lines(assessment)
    if assessment.coupling:
        warning = "" if assessment.coupling.positive else "; D(θ) is not positive definite: NOT PHYSICAL"
        share = f"{100 * assessment.coupling.share:.0f} % of the total"
        yield f"Inertia coupling between the joints: the off-diagonal part of D(θ), Eq. (27), is {share}{warning}."
    yield from _cutoff_lines(model, assessment)


def warning_lines(assessment: Assessment, certain: bool = False) -> Iterator[str]:
    """Yield what speaks against the model; `certain`: without what may be chance, and without single frictions."""
    for warning in assessment.warnings:
        if not certain or warning.kind != "not-physical" or (warning.significant and warning.of_bodies):
            yield warning.line


def scale_line(scale_uncertainty: float, relative: bool) -> str:
    """What the torque gain adds to the intervals of all parameters alike."""
    if not scale_uncertainty:
        return "Scale: torque was measured, the gain adds nothing."
    share = f"{100 * NORMAL * scale_uncertainty:.2g} %"
    if relative:
        return f"Scale: all share one unknown factor, within ± {share} of the assumed gain; only ratios are known."
    return f"Scale: all share one factor, the calibrated gain, which adds ± {share}."


def _noise_line(model: ModelFile, assessment: Assessment) -> str:
    signal = f"{', '.join(two_digits(joint.volts) for joint in assessment.noise)} {assessment.noise[0].unit}"
    source = f"Noise of the drive signal, from the {assessment.noise[0].source}: {signal}."
    test = model.residual_test
    if test is None or None in test.noise_rms:
        return f"{source} Noise floor: unknown." if assessment.floor is None else source
    floors, repetition, steps = (
        ", ".join(two_digits(value) for value in values if value is not None)
        for values in (test.noise_rms, test.repetition_rms, test.quantization_rms)
    )
    unit = model.effort_units[0]
    return (
        f"{source} Noise floor of the residual: {floors} {unit} RMS, of differences between repetitions "
        f"({repetition}) and quantization ({steps}). {test.sentence}"
    )


def _trend_lines(model: ModelFile, assessment: Assessment) -> Iterator[str]:
    """Yield changes between repetitions, unless another effect is missing, which may look like one."""
    if model.residual_test is None or model.residual_test.verdict == "above-noise":
        return
    for number, joint in enumerate(assessment.floor or (), start=1):
        if joint.trend:
            yield (
                f"Joint {number}: the residual changes from repetition to repetition ({joint.trend.pattern}, "
                f"p = {joint.trend.p_value:.1g}); the change is within the noise floor."
            )


def _identifiability_line(model: ModelFile, assessment: Assessment) -> str:
    identifiable = [parameter.name for parameter in model.parameters if parameter.status == "identifiable"]
    remaining = {status: [p.name for p in model.parameters if p.status == status] for status in ("weak", "not")}
    labels = {"weak": "only weakly identifiable", "not": "NOT identifiable"}
    exceptions = [f"{labels[status]}: {', '.join(names)}" for status, names in remaining.items() if names]
    subject = "all parameters" if len(identifiable) == len(model.parameters) else f"{len(identifiable)} parameters"
    told = f"the motion, without noise, tells {subject} apart"
    return f"Condition number {assessment.condition_number:.3g}: {'; '.join([told, *exceptions])}."


def _correlation_lines(model: ModelFile, assessment: Assessment) -> Iterator[str]:
    names = [each.name for each in (*model.parameters, *model.searched)]
    pairs = sorted(
        (
            (rho, names[i], names[j])
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


def two_digits(value: float) -> str:
    """Format `value` with two significant digits, or as a whole number from 100 on."""
    return f"{value:.2g}" if value < 100 else f"{value:.0f}"


def data_warnings(sources: Iterable[RecordingSource], recordings: Iterable[Recording]) -> Iterator[str]:
    """Yield which recordings are simulated or incomplete."""
    simulated = [source.name for source in sources if source.simulated]
    if simulated:
        yield f"SIMULATED data: {', '.join(simulated)}."
    incomplete = [recording.path.name for recording in recordings if not recording.complete]
    if incomplete:
        yield f"Interrupted recording, used up to its end: {', '.join(incomplete)}."
