"""Convert a diagnosis to the document that is printed: sentences and numbers."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.advice import fit_command, next_motion
from ident.diagnosis.document.document import (
    Document,
    EvidenceEntry,
    FindingEntry,
    FindingStatus,
    LearnedCurveEntry,
    ParameterValue,
    Remaining,
    StepEntry,
    Verdict,
)
from ident.diagnosis.document.estimate_consistency import consistency_warnings
from ident.diagnosis.document.rejections import rejected_effects
from ident.diagnosis.document.ripple_document import (
    above_low_pass,
    describe_ripple,
    ripple_step,
    step_errors,
    with_ripple,
)
from ident.diagnosis.document.verdict_rule import Remainder, verdict_of
from ident.diagnosis.document.warnings import data_warnings, file_names
from ident.diagnosis.judge.confirmation import is_supported
from ident.diagnosis.judge.rules.amplitude import size_warnings
from ident.diagnosis.judge.rules.mechanism import sign_warnings
from ident.diagnosis.search.selection import Finding, SelectionStep
from ident.diagnosis.split.parameter_intervals import with_gain
from ident.diagnosis.split.split_data import SplitData, rms
from ident.dynamics.effects.learned_curve import effect_file_text
from ident.identification.identify import is_relative
from ident.uncertainty.assessment import gain_uncertainty, interval_or_none
from recordings.recording import Floats


def to_document(diagnosis: Diagnosis) -> Document:
    """The document of a `diagnosis`."""
    split, selection = diagnosis.split, diagnosis.selection
    rig = split.recordings[0].recording.rig
    verdict, ripple, floor = _verdict(diagnosis), diagnosis.ripple, selection.model.noise_floor
    of_selection = [step_entry(split, step, step_errors(ripple, step.model)) for step in selection.steps]
    steps = (*of_selection, *ripple_step(ripple, of_selection[-1]))
    noise = ripple.with_noise(floor.rms)
    torque = rms([data.torque for data in split.recordings], split.test)
    blocked = verdict == "implausible-data"
    findings = with_ripple([_finding(diagnosis, finding) for finding in merge_repeated(selection.findings)], ripple)
    return Document(
        schema=2,
        verdict=verdict,
        sentence=_sentence(diagnosis, verdict),
        data_problems=diagnosis.data_problems,
        bandwidth_hz=ripple.upper,
        noise_rms=_numbers(noise),
        noise_ci95=tuple((low, high) for low, high in ((noise / floor.rms)[:, None] * floor.ci95).tolist()),
        noise_source=floor.source,
        torque_rms=_numbers(split.torque_rms),
        explained_share=_numbers(1 - (np.array(steps[-1].held_out_rms) / torque) ** 2),
        joints=rig.joint_names,
        effort_units=rig.effort_units,
        relative=is_relative(split.recordings[0].recording),
        scale_uncertainty=gain_uncertainty(split.recordings[0].recording),
        simulated=any(data.recording.run.simulated for data in split.recordings),
        held_out=describe_test_data(split),
        steps=steps,
        findings=() if blocked else findings,
        likely=() if blocked else tuple(_likely(finding) for finding in selection.likely),
        rejected=tuple(rejected_effects(diagnosis)),
        remaining=Remaining(
            structured_share=diagnosis.unexplained.share,
            depends_on=diagnosis.unexplained.variables,
            why=diagnosis.unexplained.sentence,
            structured_rms=_numbers(diagnosis.unexplained.rms),
        ),
        above_low_pass=above_low_pass(ripple),
        next_motion=next_motion(diagnosis, _new_findings(diagnosis)),
        warnings=(
            *_bias_warning(diagnosis),
            *consistency_warnings(selection.model, steps),
            *sign_warnings(selection.model),
            *size_warnings(selection.model),
            *data_warnings(split, selection.model, floor),
        ),
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


def _numbers(values: Floats) -> tuple[float, ...]:
    return tuple(float(value) for value in values)


def _new_findings(diagnosis: Diagnosis) -> list[Finding]:
    """Findings that are neither mandatory effects nor part of the initial model, and that the test rows support."""
    initial = _initial_effects(diagnosis)
    return [
        finding
        for finding in merge_repeated(diagnosis.selection.findings)
        if not finding.term.effect.mandatory
        and finding.term.name not in initial
        and _is_supported(diagnosis, finding)
    ]


def _is_supported(diagnosis: Diagnosis, finding: Finding) -> bool:
    """Whether the test rows support a finding. This is open only for forced effects, which are added in any case."""
    return not diagnosis.forced or is_supported(finding.improvement)


def _initial_effects(diagnosis: Diagnosis) -> set[str]:
    """Names of the effects of the initial model."""
    return diagnosis.selection.steps[0].model.names


def merge_repeated(findings: Sequence[Finding]) -> list[Finding]:
    """Merge the findings of the same effect: several lines of a spectrum become one finding.

    The finding with the largest improvement is kept, with the joints of all of them.
    """
    merged: dict[str, Finding] = {}
    for finding in findings:
        present = merged.setdefault(finding.term.name, finding)
        joints = tuple(sorted({*finding.term.joints, *present.term.joints}))
        strongest = max(finding, present, key=lambda item: item.improvement.share)
        merged[finding.term.name] = replace(strongest, term=replace(strongest.term, joints=joints))
    return list(merged.values())


def _verdict(diagnosis: Diagnosis) -> Verdict:
    model, split, first = diagnosis.model, diagnosis.split, diagnosis.selection.steps[0].model
    floor, of_band = model.noise_floor, diagnosis.ripple.lines
    left = Remainder(
        rms(model.judged_residuals, split.scored),
        floor.rms,
        floor.limit,
        split.torque_rms,
        diagnosis.unexplained.significant,
    )
    taken = 1.0 if of_band else model.improvement_over(first).share
    blocked = any(problem.blocks for problem in diagnosis.data_problems)
    return verdict_of(blocked, left, bool(_new_findings(diagnosis) or of_band), taken)


def _sentence(diagnosis: Diagnosis, verdict: Verdict) -> str:
    if verdict == "implausible-data":
        return " ".join(problem.why for problem in diagnosis.data_problems if problem.blocks)
    descriptions = [_describe(finding) for finding in _new_findings(diagnosis)]
    names = ", ".join([*descriptions, *describe_ripple(diagnosis.ripple)])
    remains = "no structured residual is left above the noise floor"
    if verdict == "unknown-structure":
        remains = "a structured residual is left"
    if diagnosis.forced:
        if not names:
            return f"{_unconfirmed(diagnosis)} Without them, {remains}: {diagnosis.unexplained.sentence}"
        return f"With {names}, as requested, {remains}: {diagnosis.unexplained.sentence}"
    initial = ", ".join(sorted(_initial_effects(diagnosis)))
    model = f"The model with {initial}" if initial else "The base model"
    if verdict == "undetermined":
        return (
            "No missing effect was found; whether more is missing is not known: these data would not show a "
            "structured residual of 3 % of the torque."
        )
    if verdict == "adequate":
        return "No structured residual is left above the noise floor: the model is adequate for these recordings."
    if verdict == "missing-effect":
        return f"{model} lacks {names}; with it, {remains}."
    subject = f"{model} lacks {names}, but a structured residual" if names else "A structured residual"
    return f"{subject} is left that no effect of the library explains: {diagnosis.unexplained.sentence}"


def _unconfirmed(diagnosis: Diagnosis) -> str:
    """Why the requested effects are not confirmed."""
    asked = [
        finding
        for finding in diagnosis.selection.findings
        if not (finding.term.effect.mandatory or finding.term.name in _initial_effects(diagnosis))
    ]
    reasons = [f"{each.term.name}: gain {each.evidence.gain:.0%}, t {each.evidence.t or 0.0:.1f}" for each in asked]
    return f"Held-out data do not confirm the requested effects ({'; '.join(reasons)})."


def _bias_warning(diagnosis: Diagnosis) -> Iterator[str]:
    """A warning that estimates may be biased while an effect is missing."""
    if diagnosis.unexplained.significant and diagnosis.selection.findings:
        yield (
            "Estimates and intervals assume that no other effect is missing, but one is: until it is found, the "
            "errors may exceed the intervals."
        )


def _describe(finding: Finding) -> str:
    term = finding.term
    joints = "" if term.effect.whole_robot else f" (joint {', '.join(str(joint + 1) for joint in term.joints)})"
    alternatives = f" or {' or '.join(finding.alternatives)}" if finding.alternatives else ""
    return f"{term.name}{joints}{alternatives}"


def describe_test_data(split: SplitData) -> str:
    """The data on which the models are validated, in words."""
    if split.other_motion:
        files = file_names(split, [i for i, rows in enumerate(split.test) if rows.any()])
        return f"{'another recording' if len(files) == 1 else 'other recordings'}: {', '.join(files)}"
    return "phase segments of the same motion, because there is no other recording: pass one with --validate"


def step_entry(
    split: SplitData, step: SelectionStep, errors: Mapping[str, tuple[float, ...]] | None = None
) -> StepEntry:
    """One model of the selection in numbers.

    errors: `train_rms` and `held_out_rms` up to the highest ripple; None: below the low-pass.
    """
    model = step.model
    below = {
        "train_rms": _numbers(rms(model.residuals, split.train)),
        "held_out_rms": _numbers(rms(model.residuals, split.test)),
        "train_rms_all": _numbers(rms(model.residuals, split.train_all)),
        "held_out_rms_all": _numbers(rms(model.residuals, split.test_all)),
    }
    return StepEntry(
        added=step.added,
        effects=tuple(term.name for term in model.terms),
        parameters=_parameters(split, step),
        **{**below, **(errors or {})},
    )


def _parameters(split: SplitData, step: SelectionStep) -> dict[str, ParameterValue]:
    solution = step.model.solution
    recording = split.recordings[0].recording
    entries, shapes = solution.structure.parameters, step.model.shape_intervals
    totals = shapes if is_relative(recording) else with_gain(shapes, solution, gain_uncertainty(recording))
    return {
        entry.name: ParameterValue(
            value=float(value),
            unit=entry.unit,
            ci95=interval_or_none(total),
            shape_ci95=interval_or_none(shape),
            meaning=entry.meaning,
            lower=entry.lower if np.isfinite(entry.lower) else None,
            upper=entry.upper if np.isfinite(entry.upper) else None,
        )
        for entry, value, total, shape in zip(entries, solution.x, totals, shapes, strict=True)
        if entry.free or entry.term >= 0  # not friction of the mechanism that an effect replaces
    }


def _finding(diagnosis: Diagnosis, finding: Finding) -> FindingEntry:
    effect, improvement = finding.term.effect, finding.improvement
    where = "the whole robot" if effect.whole_robot else f"joint {', '.join(str(j + 1) for j in finding.term.joints)}"
    excess = "error above the noise floor"
    share, interval = _part(diagnosis, finding)
    if share is None:
        low, high = improvement.interval
        why = f"Leaving it out would add {improvement.share:.0%} of the {excess} on held-out data"
    else:
        low, high = interval or (share, share)
        why = f"It accounts for {share:.0%} of the {excess} that the first model leaves on held-out data"
    if finding.compared > 1:
        why += (
            f" ({low:.0%} to {high:.0%}: no fit used these data, but they chose among {finding.compared} models, "
            "which the interval allows for)"
        )
    if not _is_supported(diagnosis, finding):
        why = f"It was requested, but held-out data do not confirm it (t is {finding.evidence.t:.1f})"
    elif finding.alternatives:
        why += f"; on these data, {', '.join(finding.alternatives)} would explain as much in its place"
    return FindingEntry(
        effect=finding.term.name,
        joints=tuple(joint + 1 for joint in finding.term.joints),
        confusable_with=finding.alternatives,
        evidence=EvidenceEntry.of(finding.evidence),
        share=share,
        status=_status(diagnosis, finding),
        in_model=finding.term.name in _initial_effects(diagnosis),
        why=f"On {where}. {why}.",
        sentence=effect.sentence,
        symptom=effect.symptom,
        causes=effect.causes,
        remedy=effect.remedy,
    )


def _likely(finding: Finding) -> FindingEntry:
    evidence, effect = finding.evidence, finding.term.effect
    return FindingEntry(
        effect=finding.term.name,
        joints=tuple(joint + 1 for joint in finding.term.joints),
        confusable_with=finding.alternatives,
        evidence=EvidenceEntry.of(evidence),
        status="likely",
        why=(
            f"It would take {evidence.gain:.0%} of what is left above the noise floor, but these held-out rows would "
            f"confirm that with a probability of {evidence.power or 0.0:.0%} only: record a longer motion."
        ),
        sentence=effect.sentence,
        symptom=effect.symptom,
        causes=effect.causes,
        remedy=effect.remedy,
    )


def _part(diagnosis: Diagnosis, finding: Finding) -> tuple[float | None, tuple[float, float] | None]:
    """Part of a finding in the fall of the held-out excess from the first model to the last, and its interval.

    The fall is divided in proportion to what leaving out each effect alone would add to the mean square.
    """
    selection, initial = diagnosis.selection, _initial_effects(diagnosis)
    if finding.term.name in initial or len(selection.steps) < 2:
        return None, None
    added: dict[str, float] = {}
    for each in selection.findings:
        if each.term.name not in initial:
            added[each.term.name] = added.get(each.term.name, 0.0) + max(each.improvement.reduction, 0.0)
    total = sum(added.values())
    fall = selection.model.improvement_over(selection.steps[0].model, compared=finding.compared)
    part = added[finding.term.name] / total if total else 0.0
    low, high = fall.interval
    return part * fall.share, (part * low, part * high)


def _status(diagnosis: Diagnosis, finding: Finding) -> FindingStatus:
    if not _is_supported(diagnosis, finding):
        return "not-supported"
    return "asked-for" if diagnosis.forced else "supported"
