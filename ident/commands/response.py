"""`ident response`: the frequency response of an axis, from a recording of `daq response`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ident.command_options import FILE, JSON, print_result

if TYPE_CHECKING:
    from ident.data.frequency_response import FrequencyResponse
    from ident.estimation.axis_response import AxisResponse


@click.command(
    short_help="Find resonance and delay of an axis.", epilog="Example: ident response joint1.mcap --plot joint1.html"
)
@click.argument("file", metavar="FILE", type=FILE)
@click.option("-o", "--out", type=FILE, metavar="CSV", help="Write the responses as a table.")
@click.option("--plot", type=FILE, metavar="HTML", help="Write a Bode plot.")
@click.option("--force", is_flag=True, help="Replace existing files.")
@JSON
def command(file: Path, out: Path | None, plot: Path | None, force: bool, as_json: bool) -> None:
    """Estimate the frequency response of the joint that moves in FILE, a recording of `daq response`.

    The response from torque to motion tells a delay from elasticity: a delay turns the phase in proportion to the
    frequency, elasticity has an antiresonance and a resonance.
    """
    from ident.estimation.axis_response import axis_response
    from recordings.command_line import refuse_existing, say_next

    refuse_existing(out, plot, force=force, read=(file,))
    response = axis_response(file)
    if out is not None:
        out.write_text(_table(response.measured), encoding="utf-8")
    if plot is not None:
        from ident.output.figures.spectrum import bode

        bode(response.measured, response.model).write_html(plot)
    if as_json:
        print_result(response.as_json())
    else:
        click.echo(_sentences(response))
    say_next(*_next(response))


def _next(response: AxisResponse) -> tuple[str, ...]:
    if response.model.resonance is not None:
        return "ident", "effects", "joint_elasticity"
    return ("ident", "effects", "actuation_delay") if response.is_delayed else ("daq", "record", "--traj", "fig5a")


def _sentences(response: AxisResponse) -> str:
    measured, model, bandwidth = response.measured, response.model, response.bandwidth
    lines = [
        f"joint {measured.joint}: {model.lines} lines above noise and friction, up to {model.highest:.4g} Hz",
        f"position loop: -3 dB at {bandwidth:.3g} Hz"
        if bandwidth
        else "position loop: no -3 dB below the highest line",
        f"inertia {model.inertia:.3g} kg m^2, delay {1000 * model.delay:.2f} ms",
    ]
    if model.resonance is not None:
        lines.append(f"antiresonance at {model.antiresonance:.3g} Hz, resonance at {model.resonance:.3g} Hz")
    lines.append(f"the model deviates from the response by {model.misfit:.0%} (RMS)")
    lines.append(response.conclusion)
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
