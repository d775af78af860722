"""Section with the frequency response of an axis: is it a delay, or elasticity?"""

from ident.estimation.axis_response import AxisResponse
from ident.output.figures.bode import bode
from ident.output.report.blocks import Plot, ReportBlock, ReportSection, ReportTable, Text

_CAPTION = (
    "Bode plots of joint {}: how the position follows its command, and how the torque accelerates the axis. A delay "
    "turns the phase in proportion to the frequency, a resonance back and forth. Noise and friction lower the "
    "coherence."
)


def section(responses: tuple[AxisResponse, ...]) -> ReportSection:
    """Return conclusion, Bode plot and figures of each response."""
    blocks: list[ReportBlock] = []
    for index, response in enumerate(responses, start=1):
        joint = response.measured.joint
        plot = Plot(f"response-{index}", bode(response.measured, response.model), _CAPTION.format(joint))
        blocks += [Text((f"Joint {joint}: {response.conclusion}",)), plot, _table(response)]
    return ReportSection("response", "Delay or elasticity: frequency response", tuple(blocks))


def _table(response: AxisResponse) -> ReportTable:
    model = response.model
    rows = [
        ("recording", response.path.name),
        ("position loop, -3 dB", _hz(response.bandwidth)),
        ("inertia", f"{model.inertia:.3g} kg m²"),
        ("delay", f"{1000 * model.delay:.2f} ms"),
        ("antiresonance", _hz(model.antiresonance)),
        ("resonance", _hz(model.resonance)),
        ("lines used", f"{model.lines}, up to {model.highest:.3g} Hz"),
        ("deviation of the model (RMS)", f"{model.misfit:.0%}"),
    ]
    return ReportTable(("", ""), tuple(rows), words=(0, 1))


def _hz(frequency: float | None) -> str:
    return "none" if frequency is None else f"{frequency:.3g} Hz"
