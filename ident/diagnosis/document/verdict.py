"""Convert a diagnosis to the document that is printed: sentences and numbers."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.advice import fit_command, next_motion
from ident.diagnosis.document.bounds import bound_warnings
from ident.diagnosis.document.diagnosed_model import parameter_intervals
from ident.diagnosis.document.document import (
    Document,
    FindingEntry,
    LearnedCurveEntry,
    ParameterValue,
    Remaining,
    StepEntry,
    Verdict,
)
from ident.diagnosis.document.findings import found_effects, likely_effects, rejected_effects
from ident.diagnosis.document.ripple_document import above_low_pass, ripple_step, step_errors, with_ripple
from ident.diagnosis.document.verdict_rule import Remainder, sentence_of, verdict_of
from ident.diagnosis.document.warnings import data_warnings, file_names
from ident.diagnosis.search.selection import SelectionStep
from ident.diagnosis.split.split_data import SplitData, rms
from ident.dynamics.effects.learned_curve import effect_file_text
from ident.identification.identify import is_relative
from ident.uncertainty.assessment import gain_uncertainty, interval_or_none
from recordings.recording import Floats


def to_document(diagnosis: Diagnosis) -> Document:
    """The document of a `diagnosis`."""
    split, selection, ripple = diagnosis.split, diagnosis.selection, diagnosis.ripple
    unexplained, floor = diagnosis.unexplained, selection.model.noise_floor
    recording = split.recordings[0].recording
    of_selection = [step_entry(split, step, step_errors(ripple, step.model)) for step in selection.steps]
    steps = (*of_selection, *ripple_step(ripple, of_selection[-1]))
    noise = ripple.with_noise(floor.rms)
    torque = rms([data.torque for data in split.recordings], split.test)
    findings = with_ripple(found_effects(diagnosis), ripple)
    likely = tuple(likely_effects(diagnosis))
    missing = [entry for entry in findings if _is_missing(diagnosis, entry)]
    verdict, sentence = _conclusion(diagnosis, findings, missing)
    blocked = verdict == "implausible-data"
    usual = {entry.name: entry.usual for entry in ripple.structure.parameters}
    return Document(
        schema=2,
        verdict=verdict,
        sentence=sentence,
        data_problems=diagnosis.data_problems,
        bandwidth_hz=ripple.upper,
        noise_rms=_numbers(noise),
        noise_ci95=tuple(zip(*(_numbers(ripple.with_noise(side)) for side in floor.ci95.T), strict=True)),
        noise_source=floor.source,
        torque_rms=_numbers(split.torque_rms),
        explained_share=_numbers(1 - (np.array(steps[-1].held_out_rms) / torque) ** 2),
        joints=recording.rig.joint_names,
        effort_units=recording.rig.effort_units,
        relative=is_relative(recording),
        scale_uncertainty=gain_uncertainty(recording),
        simulated=any(data.recording.run.simulated for data in split.recordings),
        held_out=describe_test_data(split),
        steps=steps,
        findings=() if blocked else findings,
        likely=() if blocked else likely,
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
    if learned is None or not learned.supported:
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
    split: SplitData, step: SelectionStep, errors: Mapping[str, tuple[float, ...]] | None = None
) -> StepEntry:
    """One model of the selection in numbers.

    errors: its RMS errors up to the highest ripple, as the fields are called; None: below the low-pass.
    """
    model = step.model
    rows = {
        "train_rms": split.train,
        "held_out_rms": split.test,
        "train_rms_all": split.train_all,
        "held_out_rms_all": split.test_all,
    }
    totals, shapes = parameter_intervals(model)
    values = zip(model.solution.structure.parameters, model.solution.x.tolist(), totals, shapes, strict=True)
    return StepEntry(
        added=step.added,
        effects=tuple(term.name for term in model.terms),
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
            for entry, value, total, shape in values
            if entry.free or entry.term >= 0  # not friction of the mechanism that an effect replaces
        },
        **(errors or {name: _numbers(rms(model.residuals, scored)) for name, scored in rows.items()}),
    )


def describe_test_data(split: SplitData) -> str:
    """The data on which the models are validated, in words."""
    if split.other_motion:
        files = file_names(split, [i for i, rows in enumerate(split.test) if rows.any()])
        return f"{'another recording' if len(files) == 1 else 'other recordings'}: {', '.join(files)}"
    return "parts of the same motion that no fit uses; another motion, given with --validate, tells more"


def _numbers(values: Floats) -> tuple[float, ...]:
    return tuple(values.tolist())


def _is_missing(diagnosis: Diagnosis, entry: FindingEntry) -> bool:
    """Whether the first model lacks what was found; what every machine has does not count."""
    mandatory = diagnosis.library[entry.effect].mandatory
    return not (mandatory or entry.in_model or entry.status == "not-supported")


def _conclusion(
    diagnosis: Diagnosis, findings: Sequence[FindingEntry], missing: Sequence[FindingEntry]
) -> tuple[Verdict, str]:
    """The verdict, and its sentence; `missing`: those of the `findings` that the first model lacks."""
    model, first, unexplained = diagnosis.model, diagnosis.selection.steps[0].model, diagnosis.unexplained
    floor, split, lines = model.noise_floor, diagnosis.split, diagnosis.ripple.lines
    left = Remainder(
        rms(model.judged_residuals, split.scored), floor.rms, floor.limit, split.torque_rms, unexplained.significant
    )
    blocking = [problem.why for problem in diagnosis.data_problems if problem.blocks]
    taken = 1.0 if lines else model.improvement_over(first).share
    verdict = verdict_of(bool(blocking), left, bool(missing or lines), taken)
    if blocking:
        return verdict, " ".join(blocking)
    names = " and ".join(entry.describe(diagnosis.library[entry.effect]) for entry in missing)
    if not diagnosis.forced:
        start = f"The model with {', '.join(sorted(first.names))}" if first.names else "The base model"
        return verdict, sentence_of(verdict, left, start, names, unexplained.sentence)
    asked = [f"{entry.effect}: {entry.evidence.in_words}" for entry in findings if entry.status == "not-supported"]
    doubt = f"Held-out data do not confirm the requested effects ({'; '.join(asked)}). " if not names else ""
    remains = "a structured residual" if unexplained.significant else "no structured residual"
    with_them = f"With {names or 'them'}, as requested, {remains} is left above the noise floor"
    return verdict, f"{doubt}{with_them}: {unexplained.sentence}"
