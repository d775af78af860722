"""`ident calibrate-gain`: torque gains from a known payload."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ident import plugins
from recordings.command_line import refuse_existing

if TYPE_CHECKING:
    from ident.identification.torque_calibration import Calibration
    from recordings.recording import Recording

FILE = click.Path(path_type=Path)


@click.command(
    name="calibrate-gain",
    short_help="Find the torque gains from two recordings that differ by a known payload.",
    epilog="Example: ident calibrate-gain empty.mcap loaded.mcap --payload 1.5",
)
@click.argument("empty", metavar="FILE", type=FILE)
@click.argument("loaded", metavar="FILE", type=FILE)
@click.option(
    "--payload", type=float, required=True, metavar="KG", help="What the second recording carries in addition."
)
@click.option(
    "--preprocess",
    type=click.Choice(plugins.names("ident.data.preprocessing")),
    default="parallel",
    show_default=True,
    help="As in fit.",
)
@click.option("-o", "--out", type=FILE, metavar="FILE", help="Write the [torque] section there too.")
@click.option("--force", is_flag=True, help="Replace an existing file.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead.")
def command(
    empty: Path, loaded: Path, payload: float, preprocess: str, out: Path | None, force: bool, as_json: bool
) -> None:
    """Find the torque gains from recordings of one motion, the first without, the second with a known payload.

    Prints the section [torque] for the rig file. What is recorded or fitted with it is absolute, no longer relative.
    """
    refuse_existing(out, force=force)

    from ident.identification.torque_calibration import calibrate
    from recordings.reader import read

    recordings = (read(empty), read(loaded))
    found = calibrate(*recordings, payload, preprocess)
    if out:
        out.write_text(section(found), encoding="utf-8")
    _show(found, recordings, payload, as_json)


def section(found: Calibration) -> str:
    """The section [torque] of a rig file."""
    torque = found.torque
    gains = ", ".join(f"{gain:.6g}" for gain in torque.gain)
    return (
        f'[torque]\nmap = "{torque.map}"\ngain = [{gains}]\ngain_source = "calibrated"\n'
        f"gain_uncertainty = {torque.gain_uncertainty:.2g}\n"
    )


def _show(found: Calibration, recordings: tuple[Recording, ...], payload: float, as_json: bool) -> None:
    import json

    if as_json:
        click.echo(json.dumps(_document(found, recordings, payload), indent=2))
        return
    for line in _lines(found, recordings):
        click.echo(line, err=True)
    click.echo(section(found), nl=False)


def _lines(found: Calibration, recordings: tuple[Recording, ...]) -> list[str]:
    unit = "N m/V^2" if found.torque.map == "square" else "N m/V"
    simulated = [recording.path.name for recording in recordings if recording.run.simulated]
    lines = [f"SIMULATED data: {', '.join(simulated)}."] if simulated else []
    for number, (gain, (lowest, highest)) in enumerate(zip(found.torque.gain, found.intervals, strict=True), start=1):
        lines.append(f"joint {number}: {gain:.4g} {unit}, 95 % between {lowest:.4g} and {highest:.4g}")
    if found.differ:
        lines.append(f"The gains differ between joints, by up to {100 * found.spread:.2g} %.")
    else:
        lines.append(f"The gains do not differ between joints by more than chance (p = {found.equal_p:.2g}).")
    geometry = recordings[0].rig.geometry
    most = max(found.per_length_step.tolist(), key=abs)
    lines.append(
        f"The payload explains {100 * found.explained:.1f} % of what differs between the recordings. The intervals "
        f"take its mass and the geometry as exact: 1 % of mass is 1 % of gain; 10 mm more of L2 ({geometry.L2:g} m, "
        f"{geometry.L2_source}) are up to {100 * most:+.2g} %."
    )
    return lines


def _document(found: Calibration, recordings: tuple[Recording, ...], payload: float) -> dict[str, object]:
    return {
        "schema": 1,
        "recordings": [recording.path.name for recording in recordings],
        "simulated": any(recording.run.simulated for recording in recordings),
        "payload": payload,
        "torque": found.torque.model_dump(mode="json"),
        "gain_ci95": found.intervals.tolist(),
        "gain_relative_std": found.relative_std.tolist(),
        "explained": found.explained,
        "differ": found.differ,
        "spread": found.spread,
        "equal_p": found.equal_p,
        "relative_change_per_10mm_of_L2": found.per_length_step.tolist(),
    }
