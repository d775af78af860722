"""Sections about the recordings: rig, runs, and quality of the data."""

import numpy as np

from ident.data.samples import holds_torque
from ident.output.figures import quality
from ident.output.report.blocks import Fold, Plot, ReportBlock, ReportSection
from ident.output.report.contents import ReportContents
from ident.output.report.sections.comparison import noise
from ident.output.tables import ResultTable
from recordings.recording import Recording


def data_quality(contents: ReportContents) -> ReportSection:
    """Return gaps, lateness and noise of all recordings."""
    head = ("recording", "samples", "lost", "late, median", "late, 99 %", "late, worst", "warnings and errors")
    blocks: list[ReportBlock] = [ResultTable(head, [_samples(recording) for recording in contents.recordings])]
    for index, recording in enumerate(contents.recordings, start=1):
        if quality.has_timing(recording):
            caption = f"{recording.path.name}: how late the host began each cycle, and where samples were lost."
            blocks.append(Plot(f"timing-{index}", quality.timing(recording), caption))
    return ReportSection("quality", "Data quality", (*blocks, *noise(contents)))


def _samples(recording: Recording) -> tuple[str, ...]:
    lost = ", ".join(f"joint {i}: {n}" for i, n in enumerate(recording.gaps, start=1) if n) or "none"
    lateness = recording.lateness[np.isfinite(recording.lateness)]
    late = [f"{1e3 * x:.2f} ms" for x in np.percentile(lateness, (50, 99, 100))] if len(lateness) else ["–"] * 3
    warnings = sum(event.level in ("warning", "error", "fatal") for event in recording.events)
    return (recording.path.name, str(len(recording.time)), lost, *late, str(warnings))


def rig_and_runs(contents: ReportContents) -> ReportSection:
    """Return the machine and the motion of each recording."""
    blocks: list[ReportBlock] = [_rig(contents.recordings[0]), _runs(contents)]
    for index, recording in enumerate(contents.recordings, start=1):
        caption = "The whole run. Click a joint in the legend to hide it."
        plot = Plot(f"motion-{index}", quality.motion(recording), caption)
        blocks.append(Fold(f"The motion in {recording.path.name}", (plot,), open=index == 1))
    return ReportSection("rig", "Rig and run", tuple(blocks))


def _rig(recording: Recording) -> ResultTable:
    rig, length = recording.rig, recording.rig.geometry
    rows = [
        ("rig", rig.name),
        ("mechanism", f"{rig.mechanism}, {rig.dof} joint{'s' if rig.dof > 1 else ''}"),
        ("drives", "simulated: no real robot moved" if recording.run.simulated else "real"),
    ]
    if rig.mechanism == "delta":
        lengths = f"L1 {length.L1:g} m, L2 {length.L2:g} m ({length.L2_source}), R {length.R:g} m, r {length.r:g} m"
        rows.append(("geometry", lengths))
    if holds_torque(recording):
        rows.append(("torque", "measured, no voltage"))
    else:
        gains = ", ".join(f"{gain:g}" for gain in rig.torque.gain)
        law = "gain v |v|" if rig.torque.map == "square" else "gain v"
        rows.append(("torque from voltage", f"{law}, gain {gains} ({rig.torque.gain_source})"))
    return ResultTable(("", ""), rows, words=(0, 1))


def _runs(contents: ReportContents) -> ResultTable:
    rows = []
    for index, (recording, source) in enumerate(zip(contents.recordings, contents.sources, strict=True)):
        run = recording.run
        fitted = [name for name, model in contents.models.items() if source in model.train.recordings]
        held_out = index >= len(contents.request.recordings)
        rows.append(
            (
                recording.path.name,
                "held out" if held_out else f"fitted by {', '.join(fitted)}" if fitted else "not used by the models",
                run.trajectory,
                f"{run.cycles} × {run.period:g} s" if run.period else "–",
                f"{float(recording.time[-1]):.1f} s",
                f"{run.rate:g} Hz, {'lockstep' if run.pace == 'lockstep' else 'real time'}",
                run.start,
                (run.reason or "done") if recording.complete else "INTERRUPTED",
            )
        )
    head = ("recording", "role", "trajectory", "cycles", "duration", "rate", "start", "ended")
    return ResultTable(head, rows, words=(0, 1, 2, 5, 6, 7))
