"""Section with the quality of the data."""

import numpy as np

from ident.output.console.residuals import above_noise
from ident.output.figures import quality
from ident.output.figures.theme import number, percent
from ident.output.report.blocks import Plot, ReportBlock, ReportSection, ReportTable, Text
from ident.output.report.contents import ReportContents
from recordings.recording import Recording


def section(contents: ReportContents) -> ReportSection:
    """Return gaps, lateness and noise of all recordings."""
    blocks: list[ReportBlock] = [_samples(contents)]
    for index, recording in enumerate(contents.recordings, start=1):
        if quality.has_timing(recording):
            caption = f"{recording.path.name}: how late the host began each cycle, and where samples were lost."
            blocks.append(Plot(f"timing-{index}", quality.timing(recording), caption))
    blocks += _noise(contents)
    return ReportSection("quality", "Data quality", tuple(blocks))


def _samples(contents: ReportContents) -> ReportTable:
    head = ("recording", "samples", "lost", "late, median", "late, 99 %", "late, worst", "warnings and errors")
    return ReportTable(head, tuple(_row(recording) for recording in contents.recordings), words=(0,))


def _row(recording: Recording) -> tuple[str, ...]:
    gaps = recording.gaps
    lost = ", ".join(f"joint {i}: {n}" for i, n in enumerate(gaps, start=1) if n) or "none"
    lateness = recording.lateness[np.isfinite(recording.lateness)]
    late = [f"{1e3 * x:.2f} ms" for x in np.percentile(lateness, (50, 99, 100))] if len(lateness) else ["–"] * 3
    warnings = sum(event.level in ("warning", "error", "fatal") for event in recording.events)
    return (recording.path.name, str(len(recording.time)), lost, *late, str(warnings))


def _noise(contents: ReportContents) -> list[ReportBlock]:
    rows = []
    several = len(contents.primary_analyses) > 1
    for name, analysis in contents.primary_analyses.items():
        for joint in analysis.joints:
            summary, noise = joint.summary, joint.noise_rms
            floor = "unknown" if noise is None else f"{number(noise)} {joint.unit}"
            above = above_noise(analysis.test, joint)
            cells = (f"{number(summary.rms)} {joint.unit}", percent(summary.share), floor, above)
            rows.append((*([name] if several else []), f"joint {summary.number}", *cells))
    head = ("joint", "residual, RMS", "of the torque", "noise floor", "above the noise")
    joints = [joint for analysis in contents.primary_analyses.values() for joint in analysis.joints]
    repeated = any(joint.noise_rms is not None for joint in joints)
    scope = "the recordings held out" if contents.held_out_analyses else "all recordings"
    caption = f"Residual: measured minus computed, in {scope}, where the joint moves."
    if repeated:
        caption += " Noise floor: differences between repetitions, and quantization; no model can explain them."
    words = (0, 1) if several else (0,)
    blocks: list[ReportBlock] = [ReportTable((*(["model"] if several else []), *head), tuple(rows), caption, words)]
    if repeated:
        blocks.append(
            Plot(
                "split",
                quality.mean_square_shares(contents.primary_analyses),
                "Components of the residual's mean square.",
            )
        )
    else:
        blocks.append(Text(("No motion is repeated in these recordings, so their noise floor is unknown.",)))
    return blocks
