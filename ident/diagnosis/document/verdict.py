"""Convert a diagnosis to the document that is printed: sentences and numbers."""

from pathlib import Path

import numpy as np

from ident.basics.statistics import NORMAL
from ident.data.samples import is_relative
from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.conclusion import conclusion
from ident.diagnosis.document.document import (
    Document,
    LearnedCurveEntry,
    ParameterValue,
    Remaining,
    StepEntry,
)
from ident.diagnosis.document.findings import (
    above_low_pass,
    fit_command,
    found_effects,
    likely_effects,
    next_motion,
    rejected_effects,
)
from ident.diagnosis.document.warnings import bound_warnings, data_warnings, file_names
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.ripple.ripple import EFFECT, Ripple
from ident.diagnosis.split.split_data import SplitData, rms
from ident.dynamics.effects.learned_curve import effect_file_text
from ident.estimation.nonlinear_fit import Solution
from ident.uncertainty.assessment import gain_uncertainty, interval_or_none
from recordings.recording import Floats


def to_document(diagnosis: Diagnosis) -> Document:
    """The document of a `diagnosis`."""
    split, ripple, unexplained = diagnosis.split, diagnosis.ripple, diagnosis.unexplained
    recording, floor = split.recordings[0].recording, diagnosis.model.noise_floor
    steps = [step_entry(step.added, step.model, ripple) for step in diagnosis.selection.steps]
    if ripple.lines:
        steps.append(step_entry(EFFECT, ripple.model, ripple, with_lines=True))
    torque = rms([data.torque for data in split.recordings], split.test)
    findings, likely = found_effects(diagnosis), likely_effects(diagnosis)
    missing = [
        entry
        for entry in findings
        if not (entry.in_model or entry.status == "not-supported" or diagnosis.library[entry.effect].mandatory)
    ]
    first, last = (np.array(step.held_out_rms) for step in (steps[0], steps[-1]))
    verdict, sentence = conclusion(diagnosis, missing, (first, last))
    usual = {entry.name: entry.usual for entry in ripple.structure.parameters}
    return Document(
        schema=2,
        verdict=verdict,
        sentence=sentence,
        data_problems=diagnosis.data_problems,
        bandwidth_hz=ripple.upper,
        noise_rms=_numbers(ripple.with_noise(floor.rms)),
        noise_ci95=tuple(zip(*(_numbers(ripple.with_noise(side)) for side in floor.ci95.T), strict=True)),
        noise_source=floor.source,
        torque_rms=_numbers(split.torque_rms),
        explained_share=_numbers(1 - (last / torque) ** 2),
        joints=recording.rig.joint_names,
        effort_units=recording.rig.effort_units,
        relative=is_relative(recording),
        scale_uncertainty=gain_uncertainty(split.recordings),
        simulated=any(data.recording.run.simulated for data in split.recordings),
        held_out=describe_test_data(split),
        steps=tuple(steps),
        findings=findings,
        likely=likely,
        rejected=rejected_effects(diagnosis, {entry.effect for entry in (*findings, *likely)}),
        remaining=Remaining(
            structured_share=unexplained.share,
            depends_on=unexplained.variables,
            why=unexplained.sentence,
            structured_rms=_numbers(unexplained.rms),
        ),
        above_low_pass=above_low_pass(ripple),
        next_motion=next_motion(diagnosis, missing),
        warnings=(*bound_warnings(steps[-1].parameters, usual), *data_warnings(diagnosis)),
        recordings=tuple(file_names(split, range(len(split.recordings)))),
    )


def write_learned_curve(diagnosis: Diagnosis, path: Path) -> LearnedCurveEntry | None:
    """Write the learned curves to the effect file `path`; None if there are none that the test rows support."""
    learned = diagnosis.learned
    if learned is None or not learned.improvement.is_supported:
        return None
    about = ", ".join(dict.fromkeys(data.recording.path.name for data in diagnosis.split.recordings))
    path.write_text(effect_file_text(learned.curves, about))
    joints = tuple(sorted({curve.joint for curve in learned.curves}))
    return LearnedCurveEntry(
        file=str(path),
        command=fit_command(diagnosis, path, joints),
        joints=joints,
        over=tuple(sorted({curve.variable for curve in learned.curves})),
        held_out_rms=_numbers(rms(learned.model.residuals, diagnosis.split.test)),
        gain=learned.improvement.share,
        gain_ci95=learned.improvement.interval,
    )


def step_entry(
    added: str | None, model: FittedModel, ripple: Ripple | None = None, with_lines: bool = False
) -> StepEntry:
    """A `model` of the selection in numbers.

    ripple: up to which the errors reach; None: below the low-pass. with_lines: with the lines above the low-pass.
    """
    ripple = ripple or Ripple(model)
    whole = ripple if with_lines else Ripple(model)
    totals, shapes = parameter_intervals(model, ripple)
    lines = whole.x[len(totals) :, None] + np.outer(whole.half_widths, [-1.0, 1.0])
    entries = zip(
        whole.structure.parameters,
        whole.x.tolist(),
        [*totals, *lines],
        [*shapes, *np.full_like(lines, np.nan)],
        strict=True,
    )
    return StepEntry(
        added=added,
        effects=tuple(term.name for term in whole.structure.terms),
        parameters={
            entry.name: ParameterValue(
                value=value,
                unit=entry.unit,
                ci95=interval_or_none(total),
                shape_ci95=interval_or_none(shape),
                meaning=entry.meaning,
                lower=entry.lower if np.isfinite(entry.lower) else None,
                upper=entry.upper if np.isfinite(entry.upper) else None,
            )
            for entry, value, total, shape in entries
            if entry.free or entry.term >= 0  # not friction of the mechanism that an effect replaces
        },
        **_errors(ripple, model, with_lines),
    )


def on_rows(split: SplitData, entry: StepEntry, model: FittedModel) -> StepEntry:
    """The `entry` of a `model` with its errors on the rows of `split` instead, below the low-pass."""
    scored = FittedModel(split, model.solution)
    return entry.model_copy(update=_errors(Ripple(scored), scored))


def _errors(ripple: Ripple, model: FittedModel, with_lines: bool = False) -> dict[str, tuple[float, ...]]:
    return {name: _numbers(error) for name, error in ripple.errors(model, with_lines).items()}


def parameter_intervals(model: FittedModel, ripple: Ripple) -> tuple[Floats, Floats]:
    """(K, 2) 95 % intervals of the parameters of `model`: with the uncertainty of the gain, and for a known gain."""
    recordings, shapes = model.split.recordings, ripple.intervals(model)
    if is_relative(recordings[0].recording):
        return shapes, shapes
    return with_gain(shapes, model.solution, gain_uncertainty(recordings)), shapes


def with_gain(intervals: Floats, solution: Solution, gain_uncertainty: float) -> Floats:
    """The `intervals` (K, 2) for an exactly known gain, widened by its relative standard uncertainty.

    It applies to the parameters that are proportional to the torque.
    """
    if not gain_uncertainty:
        return intervals  # not those that rounding makes of them
    proportional = np.where(solution.structure.linear, np.abs(solution.x), 0.0)
    width = np.hypot((intervals[:, 1] - intervals[:, 0]) / 2, NORMAL * gain_uncertainty * proportional)
    return np.stack([solution.x - width, solution.x + width], axis=1)


def describe_test_data(split: SplitData) -> str:
    """The data on which the models are validated, in words."""
    if split.other_motion:
        files = file_names(split, [i for i, rows in enumerate(split.test) if rows.any()])
        return f"{'another recording' if len(files) == 1 else 'other recordings'}: {', '.join(files)}"
    return "parts of the same motion that no fit uses; another motion to validate with tells more"


def _numbers(values: Floats) -> tuple[float, ...]:
    return tuple(values.tolist())
