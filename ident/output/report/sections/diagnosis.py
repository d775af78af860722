"""Sections of a diagnosis: the fall of the error, findings, torque before and after, what remains, other effects."""

import shlex

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import Document, FindingEntry, joint_numbers
from ident.diagnosis.document.findings import merge_repeated
from ident.diagnosis.document.result import DiagnosisResult
from ident.diagnosis.ripple.ripple import EFFECT
from ident.diagnosis.search.selection import Finding
from ident.output.console.diagnosis import is_parameter_of
from ident.output.digits import percent
from ident.output.figures import residuals, spectrum, steps, torque
from ident.output.figures.finding import before_after, learned_curves
from ident.output.report.blocks import Card, Code, Fold, Notes, Plot, ReportBlock, ReportSection, Text
from ident.output.report.detail import ZOOM, detail, points
from ident.output.tables.diagnosis import rejected
from ident.output.tables.parameters import with_meanings
from recordings.next_command import OWN_RIG
from recordings.rig import is_default


def error(result: DiagnosisResult) -> ReportSection:
    """Return the fall of the error from model to model."""
    caption = (
        f"Error of each model on the rows it was fitted to, and on rows held out ({result.document.held_out}). A bar "
        "that falls in training only is overfitting. The dashed line is the error of a correct model."
    )
    plot = Plot("steps", steps.error_steps(result.document), caption)
    return ReportSection("steps", "How far the error falls", (plot,))


def findings(result: DiagnosisResult) -> ReportSection:
    """Return every effect found, with its evidence."""
    diagnosis, document = result.diagnosis, result.document
    below = {finding.term.name: finding for finding in merge_repeated(diagnosis.selection.findings)}
    # Effects that every machine of this kind has come last: they are no findings.
    entries = sorted(document.findings, key=lambda entry: diagnosis.library[entry.effect].mandatory)
    blocks: list[ReportBlock] = []
    for problem in document.data_problems:
        blocks += [Text((f"{problem.kind}: {problem.why}",)), Code((problem.remedy,))]
    blocks += [
        _card(index, diagnosis, document, entry, below.get(entry.effect)) for index, entry in enumerate(entries, 1)
    ]
    if not entries:
        blocks.append(Text(("No effect was found.",)))
    for likely in document.likely:
        blocks.append(Text((f"Likely: {likely.effect} ({joint_numbers(likely.joints)}). {likely.why}",)))
    if document.warnings:
        blocks.append(Notes(document.warnings))
    return ReportSection("findings", "Findings", tuple(blocks))


def _card(index: int, diagnosis: Diagnosis, document: Document, entry: FindingEntry, finding: Finding | None) -> Card:
    effect = diagnosis.library[entry.effect]
    tags = ["whole robot" if effect.whole_robot else joint_numbers(entry.joints)]
    if entry.share is not None:
        tags.append(f"{percent(entry.share)} of the first model's held-out error above the noise floor")
    if effect.mandatory:
        tags.append("always included")
    tags += [f"or: {alternative}" for alternative in entry.confusable_with]
    blocks: list[ReportBlock] = [Text((entry.sentence,))]
    if finding:
        caption = f"Residual without {entry.effect} and with it; dots are samples, lines their means."
        blocks.append(Plot(f"finding-{index}", before_after(diagnosis, finding), caption))
    if entry.effect == EFFECT and diagnosis.ripple.lines:
        caption = "Amplitude above the low-pass over the periods per turn, without the lines and with them."
        blocks.append(Plot(f"finding-{index}-orders", spectrum.orders(diagnosis.ripple), caption))
    notes = {
        "Symptom": entry.symptom,
        "Evidence": entry.why,
        "Usual causes": f"{entry.causes}.",
        "What to do": f"{entry.remedy}.",
        "Equation": effect.equation,
    }
    blocks.append(Notes(tuple(f"{label}: {text}" for label, text in notes.items())))
    last = document.steps[-1].parameters
    parameters = {name: value for name, value in last.items() if is_parameter_of(name, entry.effect)}
    if parameters:
        blocks.append(with_meanings(parameters))
    return Card(entry.effect, tuple(tags), tuple(blocks))


def before_and_after(result: DiagnosisResult) -> ReportSection:
    """Return the torque of the first and the last model of a diagnosis; the first recording held out is open."""
    split = result.diagnosis.split
    open_index = next((i for i, rows in enumerate(split.train) if not rows.any()), 0)
    count = points(sum(5 * data.torque.shape[1] for data in split.recordings))
    blocks = []
    for number, data in enumerate(split.recordings):
        caption = (
            f"Measured torque, and that of the first and the last model; below it what each leaves, low-pass "
            f"{data.bandwidth:g} Hz. {ZOOM} {detail(len(data.time), count)}"
        )
        plot = Plot(f"before-after-{number + 1}", torque.before_and_after(result.diagnosis, number, count), caption)
        title = data.recording.path.name + (", held out" if not split.train[number].any() else "")
        blocks.append(Fold(title, (plot,), open=number == open_index))
    return ReportSection("before-after", "Torque before and after", tuple(blocks))


def remaining(result: DiagnosisResult) -> ReportSection:
    """Return the residual of the last model."""
    diagnosis, document = result.diagnosis, result.document
    analysis = steps.last_residual(diagnosis)
    summary = document.remaining
    sentences = [f"{summary.why[0].upper()}{summary.why[1:]}"]
    if document.verdict not in ("adequate", "missing-effect"):
        structured = percent(summary.structured_share)
        sentences.append(f"{structured} of the remaining mean square is structured; the rest is noise.")
    if document.above_low_pass:
        sentences.append(document.above_low_pass.why)
    blocks: list[ReportBlock] = [
        Text(tuple(sentences)),
        Plot(
            "unexplained",
            steps.rms_components(diagnosis, document),
            "Noise, effect of quantization, and structured residual of all rows (their squares add up), beside the "
            "error on rows held out.",
        ),
        Plot(
            "unexplained-curves",
            residuals.curves({"last model": analysis}),
            "Residual of the last model over the quantities that it may depend on.",
        ),
    ]
    if "frequency" in summary.depends_on:
        figure = spectrum.densities({"residual of the last model": analysis})
        blocks.append(Plot("unexplained-spectrum", figure, "Residual of the last model by frequency."))
    if diagnosis.learned:
        caption = "Curves learned from the residual over what it depends on, with 95 % bands of its mean."
        blocks.append(Plot("learned", learned_curves(diagnosis, diagnosis.learned), caption))
    return ReportSection("remains", "Unexplained residual", tuple(blocks))


def next_recording(result: DiagnosisResult) -> ReportSection:
    """Return the next motion to record."""
    motion = result.document.next_motion
    nothing = (
        "Another speed separates ripple from a vibration, which keeps its frequency."
        if any("vibration" in finding.confusable_with for finding in result.findings)
        else "No further motion is needed to separate the findings from other effects."
    )
    lines = [motion.why if motion else nothing]
    untested = [entry.effect for entry in result.document.rejected if entry.status == "not-tested"]
    if untested:
        lines.append(
            f"These motions do not excite {', '.join(untested)}; another motion may, such as one from ident design."
        )
    blocks: list[ReportBlock] = [Text(tuple(lines))]
    if motion:
        known = is_default(result.diagnosis.split.recordings[0].recording.rig)
        rig = "" if known else f" --rig RIG.toml  # {OWN_RIG}"
        blocks.append(
            Code((motion.command, f"daq record --traj {shlex.quote(shlex.split(motion.command)[-1])}{rig}"))
        )
    return ReportSection("next", "What to record next", tuple(blocks))


def candidates(result: DiagnosisResult) -> ReportSection:
    """Return what each effect would explain, the effects that were not added, and the last model."""
    selection, document = result.diagnosis.selection, result.document
    blocks: list[ReportBlock] = []
    if selection.first_reductions or selection.last_reductions:
        caption = "Predicted share of the residual that each effect explains; added effects in bold."
        blocks.append(Plot("candidates", steps.candidates(result.diagnosis), caption))
    blocks.append(Fold("Effects that were not added", (rejected(document),)))
    blocks.append(Fold("Parameters of the last model", (with_meanings(document.steps[-1].parameters),)))
    return ReportSection("candidates", "Other effects", tuple(blocks))
