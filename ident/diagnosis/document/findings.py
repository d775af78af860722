"""What a diagnosis says of each effect of the library, with the reason, and the commands that follow."""

import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import (
    AboveLowPass,
    FindingEntry,
    NextMotion,
    RejectedEntry,
    VibrationEntry,
    joint_numbers,
    share_in_words,
)
from ident.diagnosis.judge.judge import Rejection, RejectionStatus
from ident.diagnosis.ripple.ripple import EFFECT, Ripple
from ident.diagnosis.search.selection import Finding
from ident.dynamics.effects.library import names as built_in
from recordings.command_line import repeated
from recordings.next_command import design


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


def found_effects(diagnosis: Diagnosis) -> tuple[FindingEntry, ...]:
    """The effects of the last model, in the order in which they were added, with the lines above the low-pass."""
    merged = merge_repeated(diagnosis.selection.findings)
    return with_ripple([_found(diagnosis, finding) for finding in merged], diagnosis.ripple)


def _found(diagnosis: Diagnosis, finding: Finding) -> FindingEntry:
    term, steps, improvement = finding.term, diagnosis.selection.steps, finding.improvement
    in_model, confirmed = term.name in steps[0].model.names, finding.judgement.accepted or not diagnosis.forced
    added = not in_model and len(steps) > 1
    share, interval = _part(diagnosis, finding) if added else (improvement.share, improvement.interval)
    others, required = " or ".join(finding.alternatives), term.effect.mandatory
    where = "the whole robot" if term.effect.whole_robot else joint_numbers([joint + 1 for joint in term.joints])
    reasons = (
        (True, f"On {where}."),
        (
            confirmed,
            f"It takes {share_in_words(share, interval)} of the held-out mean square above the noise floor that the "
            f"{'first model leaves, over all joints' if added else 'model without it leaves'}.",
        ),
        (confirmed and finding.compared > 1, f"The interval allows for the choice among {finding.compared} models."),
        (confirmed and others, f"In its place, {others} would explain these data as well."),
        (not confirmed, "It is in every model of such a robot." if required else "It was requested."),
        (not confirmed, finding.judgement.rejection("").why),
    )
    return FindingEntry.of(
        term,
        finding.judgement.evidence,
        " ".join(reason for applies, reason in reasons if applies),
        confusable_with=finding.alternatives,
        status="not-supported" if not confirmed else "asked-for" if diagnosis.forced else "supported",
        in_model=in_model,
        share=share if added else None,
    )


def _part(diagnosis: Diagnosis, finding: Finding) -> tuple[float, tuple[float, float]]:
    """Part of a finding in the fall of the held-out excess from the first model to the last; its interval.

    The fall is divided in proportion to what leaving out each effect alone would add to the mean square. All joints
    count, those of other effects too, each in units of the same excess: only then the parts add up.
    """
    first, last = diagnosis.selection.steps[0].model, diagnosis.selection.steps[-1].model
    whole = last.blocks_over(first)
    added = [
        (each.term.name, float(np.sum(each.after.blocks_over(each.before).reduction / whole.scale)))
        for each in diagnosis.selection.findings
        if each.term.name not in first.names
    ]
    own, total = (
        sum(max(loss, 0.0) for name, loss in added if name in names) for names in ({finding.term.name}, dict(added))
    )
    fall = whole.improvement(finding.compared, range(len(whole.scale)))
    part = own / total if total else 0.0
    return part * fall.share, (part * fall.interval[0], part * fall.interval[1])


def with_ripple(findings: Sequence[FindingEntry], ripple: Ripple) -> tuple[FindingEntry, ...]:
    """The `findings` with the lines above the low-pass, which join what was found of the effect below it."""
    if not ripple.lines:
        return tuple(findings)
    above, by_name = _waves(ripple), {finding.effect: finding for finding in findings}
    below = by_name.setdefault(EFFECT, above)
    if below is not above:
        joints, why = tuple(sorted({*below.joints, *above.joints})), f"{below.why} {above.why}"
        by_name[EFFECT] = below.model_copy(update={"joints": joints, "why": why})
    return tuple(by_name.values())


def _waves(ripple: Ripple) -> FindingEntry:
    """The lines above the low-pass as one finding; there is at least one."""
    joints = tuple(sorted({line.joint for line in ripple.lines}))
    units = ripple.model.split.recordings[0].recording.rig.effort_units
    listing = "; ".join(
        f"joint {line.joint + 1}: {line.order:.6g} ± {line.half_width[2]:.1g}, amplitude {line.amplitude:.2g} "
        f"{units[line.joint]}, which takes the error between {line.evidence.band[0]:.0f} and "
        f"{line.evidence.band[1]:.0f} Hz from {line.evidence.before:.3g} to {line.evidence.after:.3g}"
        for line in ripple.lines
    )
    warnings = [
        f"At this speed a vibration of {line.same_frequency:.4g} Hz explains as much as the {line.order:.5g} periods "
        f"per turn of joint {line.joint + 1}: only another speed tells them apart."
        for line in ripple.lines
        if line.same_frequency is not None
    ]
    why = f"Above the low-pass, held-out rows confirm waves over the angle, in periods per turn: {listing}."
    return FindingEntry.of(
        replace(ripple.structure.terms[-1], joints=joints),
        ripple.evidence,
        " ".join((why, *warnings)),
        confusable_with=() if ripple.lines[0].same_frequency is None else ("vibration",),
    )


def likely_effects(diagnosis: Diagnosis) -> tuple[FindingEntry, ...]:
    """The effects for which the evidence speaks, but which too few rows were held out to confirm."""
    return tuple(
        FindingEntry.of(
            finding.term,
            evidence,
            f"It would take {evidence.gain:.0%} of the held-out mean square above the noise floor, but these data "
            f"would confirm a gain of this size with a probability of {evidence.power or 0.0:.0%} only. Record a "
            "longer motion.",
            confusable_with=finding.alternatives,
            status="likely",
        )
        for finding in diagnosis.selection.likely
        for evidence in [finding.judgement.evidence]
    )


def rejected_effects(diagnosis: Diagnosis, named: set[str]) -> tuple[RejectedEntry, ...]:
    """Every effect of the library that is not among the `named` ones, with the reason that weighs most."""
    selection, effects = diagnosis.selection, diagnosis.effects
    mechanism = diagnosis.split.recordings[0].recording.rig.mechanism
    reasons: dict[RejectionStatus, Mapping[str, str]] = {
        "absorbed": {
            name: f"It is part of {finding.term.name}, which was added."
            for finding in selection.findings
            for name in finding.term.effect.contains
        },
        "not-tested": effects.untested,
        "not-observable": {
            **effects.unobservable,
            **{
                name: f"It does not occur on a {mechanism} rig."
                for name, effect in diagnosis.library.items()
                if mechanism not in effect.mechanisms
            },
        },
    }
    rejected = dict(selection.rejected)
    for status, why in reasons.items():
        rejected |= {name: Rejection(status, reason) for name, reason in why.items()}
    return tuple(
        RejectedEntry(effect=name, **vars(rejected[name]))
        for name in diagnosis.library
        if name in rejected and name not in named
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
    rig = ripple.model.split.recordings[0].recording.rig
    listing = ", ".join(f"{name} {share:.1%}" for name, share in zip(rig.joint_names, shares, strict=True))
    lines = ", ".join(f"{each.frequency_hz:.4g} Hz (joint {each.joint})" for each in vibrations)
    why = (
        f"Above the low-pass, up to {highest:g} Hz, only ripple and vibrations are searched. The rest, with the "
        f"noise, is this share of the torque (RMS): {listing}."
        f"{f' Vibrations or electrical lines that keep their frequency: {lines}.' if lines else ''}"
    )
    return AboveLowPass(low_hz=ripple.low, high_hz=highest, unexplained_share=shares, vibrations=vibrations, why=why)


def next_motion(diagnosis: Diagnosis, findings: Sequence[FindingEntry]) -> NextMotion | None:
    """The motion that discriminates the `findings` from their alternatives, or else one to confirm them."""
    split, library = diagnosis.split, diagnosis.library
    files = list(dict.fromkeys(data.recording.path for data in split.recordings))
    for finding in findings:
        # No motion discriminates effects that change with time; a vibration is no effect of the library.
        name = finding.effect
        alternatives = [each for each in finding.confusable_with if each in library and library[each].axis != "time"]
        if not alternatives or library[name].axis == "time":
            continue
        options = [
            *(word for other in alternatives for word in ("--discriminate", name, other)),
            *repeated("--joint", () if library[name].whole_robot else finding.joints),
            *repeated("--effect-file", (f"{each}.py" for each in (name, *alternatives) if each not in built_in())),
        ]
        return NextMotion(
            why=f"These recordings cannot distinguish {name} from {' or '.join(alternatives)}; another motion can.",
            command=design(files, *options),
        )
    if split.other_motion or len(files) > 1:
        return None
    why = "A second, different motion would show whether the findings also hold for other motions."
    return NextMotion(why=why, command=design(files))


def fit_command(diagnosis: Diagnosis, path: Path, joints: Sequence[int]) -> str:
    """The command that fits the last model with the learned curves in the effect file `path`.

    joints: those with a curve, from 1.
    """
    split, terms = diagnosis.split, diagnosis.model.terms
    specified = [
        term.name if term.effect.whole_robot else _specified(term.name, (joint + 1 for joint in term.joints))
        for term in terms
    ]
    files = dict.fromkeys(str(split.recordings[i].recording.path) for i in split.train_indices)
    held_out = [
        str(data.recording.path) for data, rows in zip(split.recordings, split.test, strict=True) if rows.any()
    ]
    user_effects = (f"{name}.py" for name in sorted({term.name for term in terms} - set(built_in())))
    return shlex.join(
        [
            *("ident", "fit", *files),
            *repeated("--validate", held_out[:1] if split.other_motion else ()),
            *repeated("--with", (*dict.fromkeys(specified), _specified(path.stem, joints))),
            *repeated("--effect-file", (*user_effects, path)),
        ]
    )


def _specified(effect: str, joints: Iterable[int]) -> str:
    return f"{effect}:{','.join(map(str, joints))}"
