"""The verdict of a diagnosis, and what a person would say first: what is missing, how large, and what it takes."""

from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import FindingEntry, Verdict, joint_numbers
from ident.diagnosis.document.warnings import is_too_short, other_machine
from ident.diagnosis.judge.improvement import MIN_SHARE
from ident.diagnosis.ripple.ripple import Ripple
from ident.diagnosis.split.split_data import rms
from ident.dynamics.effects.in_words import size_in_words
from recordings.recording import Floats

_DETECTABLE = 0.03
"""Share of the torque of a structured residual that an adequate model must not hide."""
_MOST_WAVES = 2
"""Instances of one effect, as waves of several orders, whose sizes are said."""


def conclusion(
    diagnosis: Diagnosis, missing: Sequence[FindingEntry], errors: tuple[Floats, Floats]
) -> tuple[Verdict, str]:
    """The verdict, by the first rule that applies, and its sentences.

    missing: what was found that the first model lacked; errors: (dof,) held out, of the first model and of the last.
    """
    model, first, unexplained = diagnosis.ripple.whole, diagnosis.selection.steps[0].model, diagnosis.unexplained
    floor, torque, lines = model.noise_floor, diagnosis.split.torque_rms, diagnosis.ripple.lines
    exceeds = bool((rms(model.judged_residuals, diagnosis.split.scored) > floor.limit).any())
    negligible = exceeds and missing and not lines and model.improvement_over(first).share < MIN_SHARE
    hidden = bool((np.hypot(floor.rms, _DETECTABLE * torque) <= floor.limit).any())
    short = is_too_short(diagnosis.model)
    found, fall = (
        " ".join(_described(diagnosis.ripple, entry) for entry in missing),
        _fall(diagnosis, missing, errors),
    )
    known = f"{found} {fall}".strip()
    structure = f"structured residual is left that no effect of the library explains: {unexplained.sentence}"
    other = other_machine(diagnosis.model)
    open_question = "No missing effect was found, but one may be missing"
    if diagnosis.selection.likely:
        names = " and ".join(dict.fromkeys(each.term.name for each in diagnosis.selection.likely))
        open_question = f"No missing effect was confirmed, but {names} may be missing"
    rules: tuple[tuple[object, Verdict, str], ...] = (
        (
            unexplained.significant or negligible,
            "unknown-structure",
            " ".join(filter(None, (f"{known}, but a {structure}" if missing else f"A {structure}", other))),
        ),
        (
            (missing or lines) and short,
            "missing-effect",
            f"{known}, but these recordings are too short to tell whether more is missing.",
        ),
        (
            missing or lines,
            "missing-effect",
            f"{known}, and no structured residual is left above the noise floor.",
        ),
        (
            exceeds,
            "undetermined",
            f"{open_question}: the error exceeds the noise floor, but nothing in it repeats with the motion.",
        ),
        (
            hidden,
            "undetermined",
            f"{open_question}: noise would hide a structured residual of {_DETECTABLE:.0%} of the torque.",
        ),
        (short, "undetermined", f"{open_question}: these recordings are too short to tell."),
        (
            True,
            "adequate",
            "No structured residual is left above the noise floor: the model is adequate for these recordings.",
        ),
    )
    verdict, sentence = next((verdict, sentence) for applies, verdict, sentence in rules if applies)
    return verdict, _on_requested(diagnosis, found, fall) if diagnosis.forced else sentence


def _described(ripple: Ripple, entry: FindingEntry) -> str:
    """What the effect of `entry` does, and in parentheses its name, its joints, and how large it is."""
    sizes = [*_sizes(ripple, entry.effect)]
    others = [f"and {len(sizes) - _MOST_WAVES} more"] if len(sizes) > _MOST_WAVES else []
    name = " or ".join((entry.effect, *entry.confusable_with))
    return f"{entry.sentence.removesuffix('.')} ({name}{'; '.join([*sizes[:_MOST_WAVES], *others])})."


def _sizes(ripple: Ripple, name: str) -> Iterator[str]:
    """Yield joints and size of each instance of the effect `name`; joints of other units apart."""
    structure, units = ripple.structure, ripple.structure.rig.position_units
    for index, term in enumerate(structure.terms):
        if term.name != name:
            continue
        local, shapes = structure.local_values(index, ripple.x), structure.shape_values(index, ripple.x)
        own = shapes.reshape(term.instances if term.effect.local_shapes else 1, -1)
        rows = sorted(range(term.instances), key=lambda row: units[term.joints[row]])
        for _, group in groupby(rows, key=lambda row: units[term.joints[row]]):
            alike = [*group]
            joints = [term.joints[row] for row in alike]
            size = size_in_words(
                term.effect, structure.rig, joints[0], local[alike], own[alike] if len(own) > 1 else own
            )
            alone = term.effect.whole_robot or structure.rig.dof == 1
            yield f"{'' if alone else f' on {_spoken(joints)}'}: {size}"


def _spoken(joints: Sequence[int]) -> str:
    """The `joints` (from 0) in words: three and more in a row as a range."""
    if len(joints) > 2 and joints[-1] - joints[0] == len(joints) - 1:
        return f"joints {joints[0] + 1} to {joints[-1] + 1}"
    return joint_numbers([joint + 1 for joint in joints])


def _fall(diagnosis: Diagnosis, missing: Sequence[FindingEntry], errors: tuple[Floats, Floats]) -> str:
    """How the held-out error of the joint falls that was worst for its torque, and by what."""
    (before, after), first = errors, diagnosis.selection.steps[0].model
    rig = diagnosis.split.recordings[0].recording.rig
    usual = sorted(name for name in diagnosis.model.names - first.names if diagnosis.library[name].mandatory)
    beside = "".join(f", and {name}, which every such robot has," for name in usual)
    joint = int(np.argmax(before / diagnosis.split.torque_rms))
    which = f" of joint {joint + 1}" if rig.dof > 1 else ""
    direction = "falls" if after[joint] < before[joint] else "changes"
    return (
        f"With {'it' if len(missing) == 1 else 'them'}{beside} the held-out error{which} {direction} from "
        f"{before[joint]:.2g} to {after[joint]:.2g} {rig.effort_units[joint]}"
    )


def _on_requested(diagnosis: Diagnosis, found: str, fall: str) -> str:
    """The sentences on effects that the user requested; `found`: on those that the first model lacks, if any."""
    doubts = " ".join(
        f"{each.term.name} is not confirmed. {each.judgement.rejection('').why}"
        for each in diagnosis.selection.findings
        if not (each.judgement.accepted or each.term.effect.mandatory)
    )
    remains = "a structured residual" if diagnosis.unexplained.significant else "no structured residual"
    left = f"{remains} is left above the noise floor: {diagnosis.unexplained.sentence}"
    ends = [f"{fall}, and {left}"] if found else [f"With what was requested, {left}"]
    return " ".join(filter(None, [doubts, found, *ends]))
