"""Print what recordings can show."""

from rich.console import Console

from ident.diagnosis.visibility.check import CheckDocument, CheckedEffect, CheckedJoint
from ident.output.console.printing import print_command, print_plain, print_simulated, print_table, show_problems
from ident.output.tables import ResultTable

_EVEN = 1e-4
"""Steps of time with less jitter than this are even."""
_GROUPS = {
    "visible": "visible",
    "confusable": "visible, but others would explain it as well",
    "not-visible": "not visible",
}


def show(document: CheckDocument, console: Console) -> None:
    """Print the recordings, the joints, and for every effect whether they show it, and what to record if not."""
    print_simulated(console, any(recording.simulated for recording in document.recordings))
    show_problems(document.data_problems, console)
    for recording in document.recordings:
        steps = f"steps jitter by {100 * recording.jitter:.2g} %" if recording.jitter > _EVEN else "even steps"
        cycles = f"{recording.cycles} cycles" if recording.cycles > 1 else "nothing repeats"
        facts = f"{recording.rate_hz:.4g} Hz, {steps}, {recording.duration_s:.3g} s, {cycles}"
        print_plain(console, f"{recording.file}: {facts}")
    print_table(console, _joint_table(document.joints))
    share = f"{100 * document.share:.2g} % of the joint's (RMS), below {document.bandwidth_hz:g} Hz"
    print_plain(console, f"Effects whose torque is {share}:")
    for status, heading in _GROUPS.items():
        entries = [entry for entry in document.effects if entry.status == status]
        if entries:
            print_plain(console, f"\n{heading}", "bold")
        for entry in entries:
            _print_effect(entry, len(document.joints), console)


def _joint_table(joints: tuple[CheckedJoint, ...]) -> ResultTable:
    rows = [
        (
            joint.joint,
            f"{joint.travel:.3g} {joint.position_unit}",
            f"{joint.highest_speed:.3g} {joint.position_unit}/s",
            f"± {100 * joint.speed_spread:.0f} %",
            f"{100 * joint.forward_share:.0f} %",
            f"{joint.encoder_step:.2g} {joint.position_unit}" if joint.encoder_step else "none",
            f"{joint.torque_rms:.3g} {joint.effort_unit}",
            f"{joint.noise_rms:.2g} {joint.effort_unit}",
        )
        for joint in joints
    ]
    head = ("joint", "travel", "fastest", "speeds", "forward", "encoder step", "torque", "noise floor")
    return ResultTable(head, rows, words=(), title="Joints")


def _print_effect(entry: CheckedEffect, dof: int, console: Console) -> None:
    some = f" (joint {', '.join(map(str, entry.joints))})" if 0 < len(entry.joints) < dof else ""
    print_plain(console, f"  {entry.effect}{some}: {entry.why}")
    if entry.record:
        print_plain(console, f"    {entry.record}")
    if entry.command:
        print_command(console, f"    {entry.command}")
