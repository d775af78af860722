"""Draw the residual of the last model of a diagnosis."""

from collections.abc import Sequence

import plotly.graph_objects as go

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import Document
from ident.diagnosis.unknown.residual_test import residual_test
from ident.identification.prediction import Prediction
from ident.output.digits import with_equal_decimals
from ident.output.figures import theme
from ident.residuals.analysis import ResidualAnalysis, analyse
from recordings.recording import Floats


def rms_components(diagnosis: Diagnosis, document: Document) -> go.Figure:
    """Draw per joint noise, effect of quantization, and structured residual beside the held-out error [N m RMS]."""
    floor, remaining = diagnosis.model.noise_floor, document.remaining
    structured = ("structured", remaining.structured_rms, theme.CATEGORIES[0])
    components: list[tuple[str, Sequence[float] | Floats, str]] = [
        ("noise", floor.noise, theme.NOISE),
        ("quantization", floor.quantization, theme.CATEGORIES[1]),
        *([structured] if diagnosis.unexplained.significant else []),
        ("held-out error", document.steps[-1].held_out_rms, theme.MEASURED),
    ]
    figure = theme.subplots(1, 1, 280)
    texts = iter(with_equal_decimals([float(value) for _, values, _ in components for value in values]))
    for label, values, colour in components:
        figure.add_bar(
            x=[f"joint {joint}" for joint in range(1, len(values) + 1)],
            y=[float(value) for value in values],
            name=label,
            marker_color=colour,
            text=[next(texts) for _ in values],
            textposition="outside",
            cliponaxis=False,
        )
    figure.update_yaxes(title_text=f"RMS [{document.effort_units[0]}]", rangemode="tozero")
    return figure


def last_residual(diagnosis: Diagnosis) -> ResidualAnalysis:
    """Analyse the residual of the last model on all rows of the diagnosis."""
    split, model = diagnosis.split, diagnosis.model
    predictions = list(map(Prediction, split.recordings, model.computed, split.scored))
    return analyse(None, predictions, residual_test(model, diagnosis.unexplained, diagnosed=True))
