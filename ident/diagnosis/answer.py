"""Convert a diagnosis to the document that is printed: sentences and numbers."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ident.data.samples import holds_torque
from ident.diagnosis.advice import next_motion, fit_command
from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document import (
    Document,
    FindingEntry,
    FindingStatus,
    RejectedEntry,
    Remaining,
    StepEntry,
    LearnedCurveEntry,
    ParameterValue,
    Verdict,
)
from ident.diagnosis.intervals import confidence_intervals
from ident.diagnosis.split_data import SplitData, rms
from ident.diagnosis.steps import Finding, SelectionStep
from ident.diagnosis.stepwise_selection import is_supported
from ident.diagnosis.warnings import data_warnings, file_names
from ident.dynamics.effects.learned_curve import source
from recordings.recording import Floats

_CHANCE_LEVEL = 0.01
"""Share of the loss that an effect may explain by chance."""
_MIN_ABSORBED = 0.05
"""An effect counts as absorbed if it explained more than this share of the first loss, and less than half of its
first share of the final loss."""


def to_document(found: Diagnosis) -> Document:
    """The document of a `diagnosis`."""
    material, ladder = found.split, found.selection
    rig = material.predictors[0].prepared.as_recorded.rig
    verdict = _verdict(found)
    return Document(
        schema=1,
        verdict=verdict,
        sentence=_sentence(found, verdict),
        bandwidth_hz=material.datasets[0].bandwidth,
        noise_rms=_numbers(ladder.noise_floor.rms),
        torque_rms=_numbers(material.torque_rms),
        joints=rig.joint_names,
        effort_units=rig.effort_units,
        simulated=any(data.recording.run.simulated for data in material.datasets),
        held_out=describe_test_data(material),
        rungs=tuple(step_entry(material, rung) for rung in ladder.steps),
        findings=tuple(_finding(found, finding) for finding in merge_repeated(ladder.findings)),
        rejected=tuple(_rejected(found)),
        remaining=Remaining(
            structured_share=found.unexplained.share,
            depends_on=found.unexplained.variables,
            why=found.unexplained.sentence,
            structured_rms=_numbers(found.unexplained.rms),
        ),
        next_motion=next_motion(found, _new_findings(found)),
        cautions=(
            *_bias_caution(found),
            *data_warnings(material, ladder.steps[-1].model, ladder.noise_floor, found.library.get("torque_offset")),
        ),
        recordings=tuple(file_names(material, range(len(material.datasets)))),
    )


def write_learned_curve(found: Diagnosis, path: Path) -> LearnedCurveEntry | None:
    """Write the learned curves to the effect file `path`; None if there are none that the test rows support."""
    learned = found.learned
    if learned is None or not learned.supported:
        return None
    about = ", ".join(dict.fromkeys(data.recording.path.name for data in found.split.datasets))
    path.write_text(source(learned.curves, about))
    joints = tuple(sorted({curve.joint for curve in learned.curves}))
    return LearnedCurveEntry(
        file=str(path),
        command=fit_command(found, path, joints),
        joints=joints,
        over=tuple(sorted({curve.variable for curve in learned.curves})),
        validate_rms=_numbers(rms(learned.model.residuals, found.split.test)),
        gain=learned.improvement.share,
        gain_ci95=learned.improvement.interval,
    )


def _numbers(values: Floats) -> tuple[float, ...]:
    return tuple(float(value) for value in values)


def _new_findings(found: Diagnosis) -> list[Finding]:
    """Findings that are neither mandatory effects nor part of the initial model, and that the test rows support."""
    begun = _initial_effects(found)
    return [
        one
        for one in merge_repeated(found.selection.findings)
        if not one.term.effect.always_true and one.term.name not in begun and _is_supported(found, one)
    ]


def _is_supported(found: Diagnosis, finding: Finding) -> bool:
    """Whether the test rows support a finding. This is open only for forced effects, which are added in any case."""
    return not found.forced or is_supported(finding.improvement)


def _initial_effects(found: Diagnosis) -> set[str]:
    """Names of the effects of the initial model."""
    return {term.name for term in found.selection.steps[0].model.terms}


def merge_repeated(findings: Sequence[Finding]) -> list[Finding]:
    """Merge the findings of the same effect: several lines of a spectrum become one finding.

    The finding with the largest improvement is kept, with the joints of all of them.
    """
    merged: dict[str, Finding] = {}
    for one in findings:
        other = merged.setdefault(one.term.name, one)
        joints = tuple(sorted({*one.term.joints, *other.term.joints}))
        most = max(one, other, key=lambda finding: finding.improvement.share)
        merged[one.term.name] = replace(most, term=replace(most.term, joints=joints))
    return list(merged.values())


def _verdict(found: Diagnosis) -> Verdict:
    if found.unexplained.significant:
        return "unknown-structure"
    return "missing-effect" if _new_findings(found) else "adequate"


def _sentence(found: Diagnosis, verdict: Verdict) -> str:
    names = ", ".join(_describe(one) for one in _new_findings(found))
    if found.forced:
        left = "nothing structured is left above the noise" if verdict != "unknown-structure" else "something is left"
        if not names:
            return f"What was asked for explains nothing. {left.capitalize()} without it: {found.unexplained.sentence}"
        return f"With {names}, as asked for, {left}: {found.unexplained.sentence}"
    begun = ", ".join(sorted(_initial_effects(found)))
    model = f"The model with {begun}" if begun else "The base model"
    if verdict == "adequate":
        return "Nothing structured is left above the noise: the model is adequate on these recordings."
    if verdict == "missing-effect":
        return f"{model} lacks {names}; with it, nothing structured is left above the noise."
    partly = f"{model} lacks {names}, but something else repeats" if names else "Something repeats"
    return f"{partly} that no effect of the library explains: {found.unexplained.sentence}"


def _bias_caution(found: Diagnosis) -> Iterator[str]:
    """A caution that estimates may be biased while an effect is missing."""
    if found.unexplained.significant and found.selection.findings:
        yield (
            "Values and intervals hold if nothing else is missing, but something is: they may be off by more than "
            "their intervals until that is found."
        )


def _describe(finding: Finding) -> str:
    term = finding.term
    joints = "" if term.effect.whole_robot else f" (joint {', '.join(str(joint + 1) for joint in term.joints)})"
    other = f" or {' or '.join(finding.alternatives)}" if finding.alternatives else ""
    return f"{term.name}{joints}{other}"


def describe_test_data(material: SplitData) -> str:
    """The data on which the models are validated, in words."""
    if material.other_motion:
        files = file_names(material, [i for i, held in enumerate(material.test) if held.any()])
        return f"{'another recording' if len(files) == 1 else 'other recordings'}: {', '.join(files)}"
    return "phase segments of the same motion, as there is no other recording: give one with --validate"


def step_entry(material: SplitData, rung: SelectionStep) -> StepEntry:
    """One model of the selection in numbers."""
    state = rung.model
    return StepEntry(
        added=rung.added,
        effects=tuple(term.name for term in state.terms),
        train_rms=_numbers(rms(state.residuals, material.train)),
        validate_rms=_numbers(rms(state.residuals, material.test)),
        parameters=_parameters(material, rung),
    )


def _parameters(material: SplitData, rung: SelectionStep) -> dict[str, ParameterValue]:
    solution = rung.model.solution
    recording = material.datasets[0].recording
    gain = 0.0 if holds_torque(recording) else recording.rig.torque.gain_uncertainty
    named = solution.structure.named
    limits = confidence_intervals(material, solution, gain)
    return {
        one.name: ParameterValue(
            value=float(value),
            unit=one.unit,
            ci95=(float(low), float(high)) if np.isfinite([low, high]).all() else None,
            meaning=one.meaning,
            lower=one.lower if np.isfinite(one.lower) else None,
            upper=one.upper if np.isfinite(one.upper) else None,
        )
        for one, value, (low, high) in zip(named, solution.x, limits, strict=True)
    }


def _finding(found: Diagnosis, finding: Finding) -> FindingEntry:
    effect, gain = finding.term.effect, finding.improvement
    where = "the whole robot" if effect.whole_robot else f"joint {', '.join(str(j + 1) for j in finding.term.joints)}"
    why = f"It takes away {gain.share:.0%} of the error above the noise on motion that the fit did not see"
    if not _is_supported(found, finding):
        why = "It was asked for, but motion that the fit did not see does not bear it out"
    elif finding.alternatives:
        why += f"; on these data {', '.join(finding.alternatives)} would explain as much in its place"
    return FindingEntry(
        effect=finding.term.name,
        joints=tuple(joint + 1 for joint in finding.term.joints),
        confusable_with=finding.alternatives,
        gain=gain.share,
        gain_ci95=gain.interval,
        status=_status(found, finding),
        in_model=finding.term.name in _initial_effects(found),
        why=f"On {where}. {why}.",
        sentence=effect.sentence,
        looks=effect.looks,
        causes=effect.causes,
        remedy=effect.remedy,
    )


def _status(found: Diagnosis, finding: Finding) -> FindingStatus:
    if not _is_supported(found, finding):
        return "not-supported"
    return "asked-for" if found.forced else "supported"


def _rejected(found: Diagnosis) -> Iterator[RejectedEntry]:
    ladder = found.selection
    present = {one.term.name for one in ladder.findings}
    contained = {name: one.term.name for one in ladder.findings for name in one.term.effect.contains}
    mechanism = found.split.predictors[0].prepared.as_recorded.rig.mechanism
    for name, effect in found.library.items():
        if name in present:
            continue
        if mechanism not in effect.mechanisms:
            yield RejectedEntry(
                effect=name, status="not-observable", why=f"It does not exist on mechanism {mechanism}."
            )
        elif name in found.unobservable:
            yield RejectedEntry(effect=name, status="not-observable", why=found.unobservable[name])
        elif name in contained:
            why = f"It is a part of {contained[name]}, which has been added."
            yield RejectedEntry(effect=name, status="absorbed", why=why)
        elif ladder.last_extensions.excluded.get(name) == "collinear":
            why = "This motion does not show it: other parameters can imitate all that it would change."
            yield RejectedEntry(effect=name, status="not-tested", why=why)
        elif name in ladder.last_extensions.excluded:
            why = "Looked for, and not there: it would need a sign that it cannot have."
            yield RejectedEntry(effect=name, status="not-supported", why=why)
        else:
            yield _not_added(found, name, sorted(present))


def _not_added(found: Diagnosis, name: str, present: Sequence[str]) -> RejectedEntry:
    first, last = (options.loss_reductions.get(name, 0.0) for options in (found.selection.first_extensions, found.selection.last_extensions))
    if found.forced:
        why = f"It was not asked for. It would explain {last:.1%} of what is left, at first sight."
        return RejectedEntry(effect=name, status="not-supported", why=why)
    if first > _MIN_ABSORBED and last < first / 2:
        beside = ", ".join(present)
        why = f"Alone it would explain {first:.0%} of the first residual, but once {beside} is in, {last:.1%}."
        return RejectedEntry(effect=name, status="absorbed", why=why)
    much = (
        "but motion that the fit did not see does not bear it out" if last > _CHANCE_LEVEL else "hardly more than chance"
    )
    why = f"It would explain {last:.1%} of what is left, {much}."
    return RejectedEntry(effect=name, status="not-supported", why=why, hopeless=last <= _CHANCE_LEVEL)
