"""Convert what was found above the low-pass to entries of the document."""

from collections.abc import Sequence

import numpy as np

from ident.diagnosis.document.document import (
    AboveLowPass,
    EvidenceEntry,
    FindingEntry,
    ParameterValue,
    StepEntry,
    VibrationEntry,
)
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.judge import evidence_of
from ident.diagnosis.ripple.lines import RippleLine
from ident.diagnosis.ripple.ripple import EFFECT, Ripple


def step_errors(ripple: Ripple, model: FittedModel, with_lines: bool = False) -> dict[str, tuple[float, ...]]:
    """Training and test errors of `model`, with or without the lines, as fields of a step."""
    return {name: tuple(error.tolist()) for name, error in ripple.errors(model, with_lines).items()}


def ripple_step(ripple: Ripple, last: StepEntry) -> tuple[StepEntry, ...]:
    """The step that adds all lines to the `last` step of the selection; none without lines."""
    if not ripple.lines:
        return ()
    step = StepEntry(
        added=EFFECT,
        effects=(*last.effects, *[EFFECT] * len(ripple.lines)),
        parameters={**last.parameters, **_parameters(ripple)},
        **step_errors(ripple, ripple.model, with_lines=True),
    )
    return (step,)


def _parameters(ripple: Ripple) -> dict[str, ParameterValue]:
    first = len(ripple.model.solution.x)
    entries = zip(
        ripple.structure.parameters[first:], ripple.x[first:].tolist(), ripple.half_widths.tolist(), strict=True
    )
    return {
        entry.name: ParameterValue(
            value=value,
            unit=entry.unit,
            ci95=(value - width, value + width),
            meaning=entry.meaning,
            lower=entry.lower if np.isfinite(entry.lower) else None,
            upper=entry.upper if np.isfinite(entry.upper) else None,
        )
        for entry, value, width in entries
    }


def with_ripple(findings: Sequence[FindingEntry], ripple: Ripple) -> tuple[FindingEntry, ...]:
    """The `findings` with the lines above the low-pass, which join what was found of the effect below it."""
    if not ripple.lines:
        return tuple(findings)
    entry = _finding(ripple)
    below = next((finding for finding in findings if finding.effect == EFFECT), None)
    if below is None:
        return (*findings, entry)
    joined = below.model_copy(
        update={"joints": tuple(sorted({*below.joints, *entry.joints})), "why": f"{below.why} {entry.why}"}
    )
    return tuple(joined if finding is below else finding for finding in findings)


def _finding(ripple: Ripple) -> FindingEntry:
    strongest, effect = ripple.lines[0], ripple.effect
    assert effect is not None  # there are no lines without it
    uncertain = [line for line in ripple.lines if line.same_frequency is not None]
    return FindingEntry(
        effect=EFFECT,
        joints=tuple(sorted({line.joint + 1 for line in ripple.lines})),
        confusable_with=("vibration",) if strongest in uncertain else (),
        evidence=EvidenceEntry.of(evidence_of(strongest.improvement)),
        why=" ".join([_why(ripple), *(_warning(line) for line in uncertain)]),
        sentence=effect.sentence,
        symptom=effect.symptom,
        causes=effect.causes,
        remedy=effect.remedy,
    )


def _why(ripple: Ripple) -> str:
    listing = "; ".join(
        f"joint {joint + 1}: {', '.join(_order(line) for line in ripple.lines if line.joint == joint)}"
        for joint in sorted({line.joint for line in ripple.lines})
    )
    return f"Above the low-pass, held-out rows confirm waves over the angle (periods per turn), {listing}."


def _order(line: RippleLine) -> str:
    return f"{line.order:.6g} ± {line.half_width[2]:.1g}"


def _warning(line: RippleLine) -> str:
    return (
        f"At this speed a vibration of {line.same_frequency:.4g} Hz explains as much as the {line.order:.5g} periods "
        f"per turn of joint {line.joint + 1}: only another speed tells them apart."
    )


def above_low_pass(ripple: Ripple) -> AboveLowPass | None:
    """The band above the low-pass in numbers and words; None if it was not analysed."""
    if not ripple.bands:
        return None
    highest = min(band.highest for band in ripple.bands)
    shares = tuple(ripple.unexplained_share.tolist())
    vibrations = tuple(
        VibrationEntry(joint=each.joint + 1, frequency_hz=each.frequency, amplitude=each.amplitude)
        for each in ripple.vibrations
    )
    names = ripple.model.split.recordings[0].recording.rig.joint_names
    listing = ", ".join(f"{name} {share:.1%}" for name, share in zip(names, shares, strict=True))
    why = (
        f"Above the low-pass, up to {highest:g} Hz, only ripple and vibrations are searched. The rest, with the "
        f"noise, is this share of the torque (RMS): {listing}."
    )
    if vibrations:
        lines = ", ".join(f"{each.frequency_hz:.4g} Hz (joint {each.joint})" for each in vibrations)
        why += f" Vibrations or electrical lines that keep their frequency: {lines}."
    return AboveLowPass(low_hz=ripple.low, high_hz=highest, unexplained_share=shares, vibrations=vibrations, why=why)
