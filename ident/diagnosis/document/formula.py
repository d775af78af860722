"""Describe a proposed formula in numbers and words, and write it as an effect file."""

import re
from collections.abc import Mapping

import numpy as np

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import Document, FormulaEntry, joint_numbers
from ident.diagnosis.document.verdict import step_entry
from ident.diagnosis.split.split_data import training_range
from ident.diagnosis.unknown.proposal import NAME, Proposal, propose
from ident.diagnosis.unknown.residual_test import recording_sources
from ident.dynamics.effects.base import Quantity
from ident.dynamics.effects.written_formula import FUNCTIONS

_OWN = re.compile(r"\b(q|qd|qdd|direction|load)\b")
"""Quantities of the joint on which the torque acts."""


def with_formula(diagnosis: Diagnosis, document: Document) -> tuple[Document, str | None]:
    """The `document` with a formula for what is left, or in place of a curve with knots, and its effect file.

    Without one, neither changes: held-out rows confirm none.
    """
    if (proposal := propose(diagnosis.model, diagnosis.unexplained)) is None:
        return document, None
    entry = describe(diagnosis, proposal)
    remaining = document.remaining.model_copy(update={"formula": entry})
    return document.model_copy(update={"remaining": remaining}), effect_file(diagnosis, proposal, entry)


def describe(diagnosis: Diagnosis, proposal: Proposal) -> FormulaEntry:
    """The `proposal` as `ident diagnose --json` states it."""
    step = step_entry("formula", proposal.after)
    own = {name.removeprefix(f"{NAME}."): value for name, value in step.parameters.items() if name.startswith(NAME)}
    return FormulaEntry(
        joints=tuple(joint + 1 for joint in proposal.term.joints),
        text=_text(proposal),
        parameters=own,
        held_out_rms=step.held_out_rms,
        explains=proposal.improvement.share,
        alternatives=proposal.alternatives,
        resembles=_resembles(diagnosis),
        known_for=_known_for(proposal),
    )


def _text(proposal: Proposal) -> str:
    """The formula with its coefficients; of a single joint, with its number behind its quantities."""
    text = " + ".join(
        f"{quantity.name} * {column}"
        for quantity, column in zip(proposal.effect.parameters, proposal.columns, strict=True)
    )
    if len(proposal.term.joints) == 1:
        text = _OWN.sub(rf"\g<1>{proposal.term.joints[0] + 1}", text)
    return text.replace(" * ", "·").replace(" ** ", "^")


def _resembles(diagnosis: Diagnosis) -> str | None:
    """The effect of the library that explains most of what the last model of the `diagnosis` leaves."""
    reductions = {name: share for name, share in diagnosis.selection.last_reductions.items() if share > 0}
    name = max(reductions, key=lambda each: reductions[each], default=None)
    return name and f"{name}, which would explain {reductions[name]:.0%} of the error of the fit"


def _known_for(proposal: Proposal) -> str:
    """Range of position and speed of the joints whose motion the formula uses, in the rows of the fit."""
    split, rig = proposal.after.split, proposal.after.solution.structure.rig
    foreign = {
        int(number) - 1 for text in proposal.columns for number in re.findall(r"\b(?:q|qd|qdd|direction)(\d+)", text)
    }
    signals = [[getattr(data.motion, name) for data in split.recordings] for name in ("position", "velocity")]
    (low, high), speeds = (training_range(each, split.train) for each in signals)
    fastest = np.fmax.reduce(np.abs(speeds))
    return "; ".join(
        f"joint {joint + 1} from {low[joint]:.3g} to {high[joint]:.3g} {rig.position_units[joint]}, up to "
        f"{fastest[joint]:.3g} {rig.position_units[joint]}/s"
        for joint in sorted({*proposal.term.joints, *foreign})
    )


def effect_file(diagnosis: Diagnosis, proposal: Proposal, entry: FormulaEntry) -> str:
    """The text of an effect file with the formula of the `proposal`, which `entry` describes."""
    effect = proposal.effect
    recordings = "\n".join(
        f"    {source.name}  sha256 {source.sha256}"
        for source in recording_sources([data.recording for data in diagnosis.split.recordings])
    )
    columns = re.sub(rf"\b({'|'.join(FUNCTIONS)})\(", r"np.\1(", ", ".join(proposal.columns))
    formula = columns if len(proposal.columns) == 1 else f"({columns})"
    also = f"These data cannot tell it from: {'; '.join(entry.alternatives)}.\n" if entry.alternatives else ""
    like = f"Of the library it resembles most {entry.resembles}.\n" if entry.resembles else ""
    numpy = "import numpy as np\n\n" if "np." in columns else ""
    return f'''"""Proposed by `ident diagnose --propose` for {joint_numbers(entry.joints)}: {entry.text}

It takes {entry.explains:.0%} of the held-out mean square above the noise floor that the model without it leaves.
{also}{like}Known for {entry.known_for}; beyond, it is an extrapolation. Recordings:

{recordings}
"""

{numpy}from ident.dynamics.effects.base import Additive, Quantity

effect = Additive(
    sentence="A law that no effect of the library contains acts on {joint_numbers(entry.joints)}.",
    symptom="The residual follows the formula.",
    causes="not known: look at what the formula depends on",
    remedy="look at the part itself, or add the formula to the feed-forward",
    axis="{_axis(proposal)}",
    joints={proposal.term.joints!r},
    formula=lambda {", ".join(proposal.arguments)}: {formula},
{_quantities("parameters", effect.parameters)}{_quantities("shapes", effect.shapes, proposal.shapes)})
'''


def _axis(proposal: Proposal) -> str:
    """The variable over which plots show it."""
    axes = {"qd": "velocity", "qdd": "acceleration", "t": "time", "load": "load"}
    return next((axes[name] for name in proposal.arguments if name in axes), "position")


def _quantities(key: str, quantities: tuple[Quantity, ...], values: Mapping[str, float] | None = None) -> str:
    """Lines that describe `quantities`; shapes begin at their `values`."""
    lines = []
    for each in quantities:
        words = [f'        Quantity(name="{each.name}", unit="{each.unit}", meaning="{each.meaning}"']
        if values:
            words += [f"lower={each.lower:.6g}", f"upper={each.upper:.6g}"]
            words.append(f"initial_guesses=({values[each.name]:.6g},)")
        lines.append(", ".join(words) + "),\n")
    return f"    {key}=(\n{''.join(lines)}    ),\n" if lines else ""
