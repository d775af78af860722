"""`ident calibrate-gain`: torque gains from a known payload."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ident.command_options import FILE, JSON, PREPROCESS, print_result
from recordings.command_line import FiniteRange, check_readable, refuse_existing, say, say_next
from recordings.next_command import OWN_RIG

if TYPE_CHECKING:
    from ident.identification.torque_calibration import Calibration
    from recordings.recording import Recording


@click.command(
    name="calibrate-gain",
    short_help="Find the torque gains from two recordings that differ by a known payload.",
    epilog="Example: ident calibrate-gain empty.mcap loaded.mcap --payload 1.5",
)
@click.argument("empty", metavar="FILE", type=FILE)
@click.argument("loaded", metavar="FILE", type=FILE)
@click.option(
    "--payload",
    type=FiniteRange(0, min_open=True),
    required=True,
    metavar="KG",
    help="Mass that only the second recording carries.",
)
@PREPROCESS
@click.option("-o", "--out", type=FILE, metavar="FILE", help="Also write the [torque] section to this file.")
@click.option("--force", is_flag=True, help="Replace an existing file.")
@JSON
def command(
    empty: Path, loaded: Path, payload: float, preprocess: str, out: Path | None, force: bool, as_json: bool
) -> None:
    """Find the torque gains from recordings of one motion, the first without, the second with a known payload.

    Prints the section [torque] for the rig file. With it, torques and parameters are absolute instead of relative.
    """
    check_readable(empty, loaded)
    refuse_existing(out, force=force)

    from ident.identification.torque_calibration import calibrate
    from recordings.reader import read

    recordings = (read(empty), read(loaded))
    calibration = calibrate(*recordings, payload, preprocess)
    if out:
        out.write_text(torque_section(calibration), encoding="utf-8")
    if as_json:
        print_result(_document(calibration, recordings, payload))
    else:
        click.echo("\n".join(_lines(calibration, recordings)), err=True)
        click.echo(torque_section(calibration), nl=False)
    say(OWN_RIG)
    say_next("daq", "record", "--traj", recordings[0].run.trajectory, "--rig", "RIG.toml")


def torque_section(calibration: Calibration) -> str:
    """Return the section [torque] of a rig file."""
    torque = calibration.torque
    gains = ", ".join(f"{gain:.6g}" for gain in torque.gain)
    return (
        f'[torque]\nmap = "{torque.map}"\ngain = [{gains}]\ngain_source = "calibrated"\n'
        f"gain_uncertainty = {torque.gain_uncertainty:.2g}\n"
    )


def _lines(calibration: Calibration, recordings: tuple[Recording, ...]) -> list[str]:
    unit = "N m/V^2" if calibration.torque.map == "square" else "N m/V"
    simulated = [recording.path.name for recording in recordings if recording.run.simulated]
    lines = [f"SIMULATED data: {', '.join(simulated)}."] if simulated else []
    for number, (gain, (lowest, highest)) in enumerate(
        zip(calibration.torque.gain, calibration.intervals, strict=True), start=1
    ):
        lines.append(f"joint {number}: {gain:.4g} {unit}, 95 % between {lowest:.4g} and {highest:.4g}")
    if calibration.gains_differ:
        lines.append(f"The gains differ between joints, by up to {100 * calibration.spread:.2g} %.")
    else:
        lines.append(f"The gains do not differ significantly between joints (p = {calibration.equal_p:.2g}).")
    geometry = recordings[0].rig.geometry
    largest = max(calibration.per_length_step.tolist(), key=abs)
    lines.append(
        f"The payload explains {100 * calibration.explained:.1f} % of the difference between the recordings. The "
        "intervals assume exact mass and geometry: 1 % of mass changes the gain by 1 %, 10 mm more of L2 "
        f"({geometry.L2:g} m, {geometry.L2_source}) by up to {100 * largest:+.2g} %."
    )
    return lines


def _document(calibration: Calibration, recordings: tuple[Recording, ...], payload: float) -> dict[str, object]:
    return {
        "schema": 1,
        "recordings": [recording.path.name for recording in recordings],
        "simulated": any(recording.run.simulated for recording in recordings),
        "payload": payload,
        "torque": calibration.torque.model_dump(mode="json"),
        "gain_ci95": calibration.intervals.tolist(),
        "gain_relative_std": calibration.relative_std.tolist(),
        "explained": calibration.explained,
        "differ": calibration.gains_differ,
        "spread": calibration.spread,
        "equal_p": calibration.equal_p,
        "relative_change_per_10mm_of_L2": calibration.per_length_step.tolist(),
    }
