"""Section with the frequency response of an axis: is it a delay, or elasticity?"""

from ident.estimation.axis_response import AxisResponse
from ident.output.figures.spectrum import bode
from ident.output.report.blocks import Plot, ReportBlock, ReportSection, Text
from ident.output.tables import ResultTable

_CAPTION = (
    "Bode plots of joint {}: how the position follows its command, and how the torque accelerates the axis. A delay "
    "turns the phase in proportion to the frequency, a resonance back and forth. Noise and friction lower the "
    "coherence."
)


def section(responses: tuple[AxisResponse, ...]) -> ReportSection:
    """Return conclusion, Bode plot and figures of each response."""
    blocks: list[ReportBlock] = []
    for index, response in enumerate(responses, start=1):
        joint, model = response.measured.joint, response.model
        frequencies = {
            "position loop, -3 dB": response.bandwidth,
            "antiresonance": model.antiresonance,
            "resonance": model.resonance,
        }
        shown = {name: "none" if hz is None else f"{hz:.3g} Hz" for name, hz in frequencies.items()}
        rows = {
            "recording": response.path.name,
            "inertia": f"{model.inertia:.3g} kg m²",
            "delay": f"{1000 * model.delay:.2f} ms",
            **shown,
            "lines used": f"{model.lines}, up to {model.highest:.3g} Hz",
            "deviation of the model (RMS)": f"{model.misfit:.0%}",
        }
        blocks += [
            Text((f"Joint {joint}: {response.conclusion}",)),
            Plot(f"response-{index}", bode(response.measured, model), _CAPTION.format(joint)),
            ResultTable(("", ""), tuple(rows.items()), words=(0, 1)),
        ]
    return ReportSection("response", "Delay or elasticity: frequency response", tuple(blocks))
