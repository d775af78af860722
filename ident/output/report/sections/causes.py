"""Section about where the torque goes: its causes, and what would be missing without the coupling of the joints."""

from dataclasses import replace

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.export.paths import RecordedPath
from ident.export.torque_table import TorqueSummary, evaluate
from ident.identification.model import Model
from ident.output.digits import percent
from ident.output.figures import causes
from ident.output.report.blocks import Plot, ReportSection, Text
from ident.output.report.contents import ReportContents
from ident.output.tables import ResultTable
from ident.output.tables.causes import table


def section(contents: ReportContents) -> ReportSection:
    """Return the torque of the last model by its causes, in the first recording that judges it."""
    name, analysis = list(contents.primary_analyses.items())[-1]
    model = Model(contents.models[name], contents.effects)
    blocks = torque_by_cause(model, analysis.predictions[0].prepared)
    return ReportSection("causes", f"Where the torque goes: {name}", blocks)


def torque_by_cause(model: Model, prepared: PreparedRecording) -> tuple[Text, Plot, ResultTable]:
    """Compute the torque of `model` in a recording by its causes, and draw its first repetition."""
    chunk = next(RecordedPath(prepared).chunks())
    torque, terms = evaluate(model, chunk)
    summary = TorqueSummary()
    summary.add(torque, terms)
    step = prepared.preprocessed.decimation
    cycle = slice(prepared.first_cycle.start * step, prepared.first_cycle.stop * step, step)
    shown = {cause: values[cycle] for cause, values in terms.items()}
    figure = causes.stacked(chunk.time[chunk.used][cycle], torque[cycle], shown, summary.rms, model.file.effort_units)
    caption = f"The first repetition in {prepared.recording.path.name}, and the RMS of each cause in the recording."
    return (
        Text(_sentences(summary)),
        Plot("causes", figure, caption),
        replace(table(summary), caption="RMS, and its share of the torque's."),
    )


def _sentences(summary: TorqueSummary) -> tuple[str, ...]:
    coupling, share = summary.rms["inertia_coupling"], summary.share["inertia_coupling"]
    if not coupling.any():
        return ("The causes add up to the torque. The joints move independently: no inertia couples them.",)
    worst = int(np.argmax(share))
    return (
        "The causes add up to the torque; where they oppose each other, their shares add up to more than 100 %.",
        f"Without the inertia that couples the joints, the model would lose up to {coupling[worst]:.3g} N m RMS, "
        f"{percent(float(share[worst]))} of the torque (joint {worst + 1}).",
    )
