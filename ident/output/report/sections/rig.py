"""Section with rig and runs."""

from ident.data.samples import holds_torque
from ident.output.figures import quality
from ident.output.report.blocks import Fold, Plot, ReportBlock, ReportSection, ReportTable
from ident.output.report.contents import ReportContents
from recordings.recording import Recording


def section(contents: ReportContents) -> ReportSection:
    """Return the machine and the motion of each recording."""
    blocks: list[ReportBlock] = [_rig(contents.recordings[0]), _runs(contents)]
    for index, recording in enumerate(contents.recordings, start=1):
        caption = "The whole run. Click a joint in the legend to hide it."
        plot = Plot(f"motion-{index}", quality.motion(recording), caption)
        blocks.append(Fold(f"The motion in {recording.path.name}", (plot,), open=index == 1))
    return ReportSection("rig", "Rig and run", tuple(blocks))


def _rig(recording: Recording) -> ReportTable:
    rig = recording.rig
    rows = [
        ("rig", rig.name),
        ("mechanism", f"{rig.mechanism}, {rig.dof} joint{'s' if rig.dof > 1 else ''}"),
        ("drives", "simulated: no real robot moved" if recording.run.simulated else "real"),
    ]
    if rig.mechanism == "delta":
        length = rig.geometry
        lengths = f"L1 {length.L1:g} m, L2 {length.L2:g} m ({length.L2_source}), R {length.R:g} m, r {length.r:g} m"
        rows.append(("geometry", lengths))
    if holds_torque(recording):
        return ReportTable(("", ""), (*rows, ("torque", "measured, no voltage")), words=(0, 1))
    gains = ", ".join(f"{gain:g}" for gain in rig.torque.gain)
    law = "gain v |v|" if rig.torque.map == "square" else "gain v"
    rows.append(("torque from voltage", f"{law}, gain {gains} ({rig.torque.gain_source})"))
    return ReportTable(("", ""), tuple(rows), words=(0, 1))


def _runs(contents: ReportContents) -> ReportTable:
    rows = []
    for index, (recording, source) in enumerate(zip(contents.recordings, contents.sources, strict=True)):
        run = recording.run
        fitted = [name for name, model in contents.models.items() if source in model.train.recordings]
        held_out = index >= len(contents.request.recordings)
        role = "held out" if held_out else f"fitted by {', '.join(fitted)}" if fitted else "not used by the models"
        pace = "lockstep" if run.pace == "lockstep" else "real time"
        ended = (run.reason or "done") if recording.complete else "INTERRUPTED"
        cycles = f"{run.cycles} × {run.period:g} s" if run.period else "–"
        duration = f"{float(recording.time[-1]):.1f} s"
        rate = f"{run.rate:g} Hz, {pace}"
        rows.append((recording.path.name, role, run.trajectory, cycles, duration, rate, run.start, ended))
    head = ("recording", "role", "trajectory", "cycles", "duration", "rate", "start", "ended")
    return ReportTable(head, tuple(rows), words=(0, 1, 2, 5, 6, 7))
