"""Data quality."""

import numpy as np

from ident.output.figures import quality
from ident.output.figures.theme import number, percent
from ident.output.report.blocks import ReportBlock, Plot, ReportSection, ReportTable, Text
from ident.output.report.contents import ReportContents
from recordings.recording import Recording


def section(material: ReportContents) -> ReportSection:
    """Gaps, lateness, noise."""
    blocks: list[ReportBlock] = [_samples(material)]
    for place, recording in enumerate(material.recordings, start=1):
        if quality.has_timing(recording):
            caption = f"{recording.path.name}: how late the host began each cycle, and where samples were lost."
            blocks.append(Plot(f"timing-{place}", quality.timing(recording), caption))
    blocks += _noise(material)
    return ReportSection("quality", "Data quality", tuple(blocks))


def _samples(material: ReportContents) -> ReportTable:
    head = ("recording", "samples", "lost", "late, median", "late, 99 %", "late, worst", "warnings and errors")
    return ReportTable(head, tuple(_row(recording) for recording in material.recordings), words=(0,))


def _row(recording: Recording) -> tuple[str, ...]:
    gaps = recording.gaps
    lost = ", ".join(f"joint {i}: {n}" for i, n in enumerate(gaps, start=1) if n) or "none"
    known = recording.lateness[np.isfinite(recording.lateness)]
    late = [f"{1e3 * x:.2f} ms" for x in np.percentile(known, (50, 99, 100))] if len(known) else ["–"] * 3
    loud = sum(event.level in ("warning", "error", "fatal") for event in recording.events)
    return (recording.path.name, str(len(recording.time)), lost, *late, str(loud))


def _noise(material: ReportContents) -> list[ReportBlock]:
    rows = []
    several = len(material.primary_comparisons) > 1
    for name, comparison in material.primary_comparisons.items():
        for joint in comparison.joints:
            summary, split = joint.summary, joint.split
            floor = f"{number(split.noise_rms)} {joint.unit}" if split else "unknown"
            above = percent(split.above_noise) if split else ""
            left = (f"{number(summary.rms)} {joint.unit}", percent(summary.share), floor, above)
            rows.append((*([name] if several else []), f"joint {summary.number}", *left))
    head = ("joint", "residual, RMS", "of the torque", "noise floor", "above the noise")
    known = any(joint.split for one in material.primary_comparisons.values() for joint in one.joints)
    of = "the recordings held out" if material.held_out_comparisons else "all recordings"
    caption = f"Residual: measured minus computed, of {of}."
    if known:
        caption += " The motion repeats, so what differs between repetitions is noise; no model can explain it."
    words = (0, 1) if several else (0,)
    blocks: list[ReportBlock] = [ReportTable((*(["model"] if several else []), *head), tuple(rows), caption, words)]
    if known:
        blocks.append(
            Plot("split", quality.mean_square_shares(material.primary_comparisons), "What the mean square of the residual consists of.")
        )
    else:
        blocks.append(
            Text(("No motion is repeated in these recordings, so the noise floor is not known from them.",))
        )
    return blocks
