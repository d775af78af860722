"""Print what recordings can show."""

from rich.console import Console
from rich.table import Table

from ident.diagnosis.visibility.visibility_document import CheckDocument, CheckedEffect, CheckedJoint

_EVEN = 1e-4
"""Steps of time with less jitter than this are even."""


def show(document: CheckDocument, console: Console) -> None:
    """Print the recordings, the joints, and for every effect whether they show it, and what to record if not."""
    if any(recording.simulated for recording in document.recordings):
        console.print("SIMULATED data.", style="bold yellow")
    for recording in document.recordings:
        cycles = f"{recording.cycles} cycles" if recording.cycles > 1 else "nothing repeats"
        _print_plain(
            console,
            f"{recording.file}: {recording.rate_hz:.4g} Hz, {_steps(recording.jitter)}, "
            f"{recording.duration_s:.3g} s, {cycles}",
        )
    console.print(_joint_table(document.joints))
    _print_plain(
        console,
        f"Effects whose torque is {100 * document.share:.2g} % of the joint's (RMS), "
        f"below {document.bandwidth_hz:g} Hz:",
    )
    groups = {
        "visible": "visible",
        "confusable": "visible, but others would explain it as well",
        "not-visible": "not visible",
    }
    for status, heading in groups.items():
        entries = [entry for entry in document.effects if entry.status == status]
        if entries:
            console.print(f"\n{heading}", style="bold", highlight=False)
        for entry in entries:
            _print_effect(entry, len(document.joints), console)


def _steps(jitter: float) -> str:
    return f"steps jitter by {100 * jitter:.2g} %" if jitter > _EVEN else "even steps"


def _joint_table(joints: tuple[CheckedJoint, ...]) -> Table:
    table = Table(title="Joints", title_justify="left")
    for heading in ("joint", "travel", "fastest", "speeds", "forward", "encoder step", "torque", "noise floor"):
        table.add_column(heading, justify="right")
    for joint in joints:
        table.add_row(
            joint.joint,
            f"{joint.travel:.3g} {joint.position_unit}",
            f"{joint.highest_speed:.3g} {joint.position_unit}/s",
            f"± {100 * joint.speed_spread:.0f} %",
            f"{100 * joint.forward_share:.0f} %",
            f"{joint.encoder_step:.2g} {joint.position_unit}" if joint.encoder_step else "none",
            f"{joint.torque_rms:.3g} {joint.effort_unit}",
            f"{joint.noise_rms:.2g} {joint.effort_unit}",
        )
    return table


def _print_effect(entry: CheckedEffect, dof: int, console: Console) -> None:
    some = f" (joint {', '.join(map(str, entry.joints))})" if 0 < len(entry.joints) < dof else ""
    _print_plain(console, f"  {entry.effect}{some}: {entry.why}")
    if entry.record:
        _print_plain(console, f"    {entry.record}")
    if entry.command:
        # Never wrapped, so that it can be copied.
        console.print(f"    {entry.command}", markup=False, highlight=False, soft_wrap=True)


def _print_plain(console: Console, text: str) -> None:
    """Print `text` without markup: a user's effect may have brackets in its texts."""
    console.print(text, markup=False, highlight=False)
