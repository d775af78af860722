"""`ident response`: the frequency response of an axis, from a recording of `daq response`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from ident.data.frequency_response import FrequencyResponse
    from ident.estimation.axis_model import AxisModel

FILE = click.Path(path_type=Path)


@click.command(
    short_help="Find resonance and delay of an axis.", epilog="Example: ident response joint1.mcap --plot joint1.html"
)
@click.argument("file", metavar="FILE", type=FILE)
@click.option("-o", "--out", type=FILE, metavar="CSV", help="Write the responses as a table.")
@click.option("--plot", type=FILE, metavar="HTML", help="Write a Bode plot.")
@click.option("--force", is_flag=True, help="Replace existing files.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of tables.")
def command(file: Path, out: Path | None, plot: Path | None, force: bool, as_json: bool) -> None:
    """Estimate the frequency response of the joint that moves in FILE, a recording of `daq response`.

    The response from torque to motion tells a delay from elasticity: a delay turns the phase in proportion to the
    frequency, elasticity has an antiresonance and a resonance.
    """
    import json

    from ident.data.frequency_response import frequency_response
    from ident.estimation.axis_model import fit_axis
    from recordings.command_line import refuse_existing
    from recordings.reader import read

    refuse_existing(out, plot, force=force, read=(file,))
    measured = frequency_response(read(file))
    model = fit_axis(measured)
    if out is not None:
        out.write_text(_table(measured), encoding="utf-8")
    if plot is not None:
        from ident.output.figures.bode import bode

        bode(measured, model).write_html(plot)
    click.echo(json.dumps(_document(measured, model), indent=1) if as_json else _sentences(measured, model))


def _document(measured: FrequencyResponse, model: AxisModel) -> dict[str, object]:
    return {
        "schema": 1,
        "joint": measured.joint,
        "rate": measured.rate,
        "bandwidth_hz": _bandwidth(measured),
        "inertia": model.inertia,
        "viscous": model.viscous,
        "delay": model.delay,
        "antiresonance_hz": model.antiresonance,
        "resonance_hz": model.resonance,
        "lines": model.lines,
        "highest_hz": model.highest,
        "misfit": model.misfit,
    }


def _bandwidth(measured: FrequencyResponse) -> float | None:
    """Lowest frequency at which the position follows with less than 1/sqrt(2) of the command [Hz]."""
    below = measured.frequency[abs(measured.loop) < 0.5**0.5]
    return float(below[0]) if len(below) else None


def _sentences(measured: FrequencyResponse, model: AxisModel) -> str:
    bandwidth = _bandwidth(measured)
    lines = [
        f"joint {measured.joint}: {model.lines} lines above noise and friction, up to {model.highest:.4g} Hz",
        f"position loop: -3 dB at {bandwidth:.3g} Hz"
        if bandwidth
        else "position loop: no -3 dB below the highest line",
        f"inertia {model.inertia:.3g} kg m^2, delay {1000 * model.delay:.2f} ms",
    ]
    if model.resonance is None:
        lines.append("no resonance: the axis is rigid in this range")
    else:
        lines.append(f"elastic: antiresonance at {model.antiresonance:.3g} Hz, resonance at {model.resonance:.3g} Hz")
    lines.append(f"the model deviates from the response by {model.misfit:.0%} (RMS)")
    return "\n".join(lines)


def _table(measured: FrequencyResponse) -> str:
    import numpy as np

    columns = {
        "frequency": measured.frequency,
        "loop_magnitude": np.abs(measured.loop),
        "loop_phase": np.angle(measured.loop),
        "loop_coherence": measured.loop_coherence,
        "motion_magnitude": np.abs(measured.motion),
        "motion_phase": np.angle(measured.motion),
        "motion_coherence": measured.motion_coherence,
        "motion_deviation": measured.motion_deviation,
    }
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    return "\n".join([",".join(columns), *(",".join(f"{value:.9g}" for value in row) for row in rows)]) + "\n"
