"""Draw the error after each step of the selection, what each effect would improve, and what the last model leaves."""

from collections.abc import Sequence

import plotly.graph_objects as go

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import Document, StepEntry
from ident.diagnosis.unknown.residual_test import residual_test
from ident.identification.prediction import Prediction
from ident.output.digits import number, with_equal_decimals
from ident.output.figures import theme
from ident.residuals.analysis import ResidualAnalysis, analyse
from recordings.recording import Floats

MAX_CANDIDATES = 14
"""Number of candidates that are drawn at most."""


def error_steps(document: Document) -> go.Figure:
    """Draw training and held-out RMS of each step of the selection per joint, with the noise floor as a line."""
    names = [theme.escaped(label) for label in document.labels]
    return rms_bars(names, document.steps, document.noise_rms, document.effort_units)


def rms_bars(
    names: Sequence[str], steps: Sequence[StepEntry], noise: Sequence[float | None], units: Sequence[str]
) -> go.Figure:
    """Draw training and held-out RMS of models `steps` called `names`; `noise` (None: unknown), `units` per joint."""
    height = theme.HEADER + theme.FOOTER + 20 + 58 * len(names)
    figure = theme.beside_each_other(range(len(units)), height, shared_yaxes=True, horizontal_spacing=0.03)
    for joint, unit in enumerate(units):
        colour, place = theme.joint_colour(joint), {"row": 1, "col": joint + 1}
        series = [
            ("training", [step.train_rms[joint] for step in steps], theme.with_opacity(colour, theme.FAINT_OPACITY)),
            ("held out", [step.held_out_rms[joint] for step in steps], colour),
        ]
        for label, values, fill in series:
            figure.add_bar(
                x=values,
                y=list(range(len(names))),
                orientation="h",
                name=label,
                text=[number(value, 2) for value in values],
                textposition="outside",
                cliponaxis=False,
                marker_color=fill,
                showlegend=False,
                hovertemplate=f"{label}: %{{x:.3g}} {unit}<extra></extra>",
                **place,
            )
        largest = max(max(step.train_rms[joint], step.held_out_rms[joint]) for step in steps)
        if noise[joint] is not None:
            figure.add_vline(x=noise[joint], line=theme.NOISE_LINE, **place)
        figure.update_xaxes(title_text=f"RMS error [{unit}]", range=[0, 1.22 * largest], **place)
    fills = {"training": theme.with_opacity(theme.MEASURED, theme.FAINT_OPACITY), "held out": theme.MEASURED}
    for label, fill in fills.items():
        theme.legend_entry(figure, label, marker={"symbol": "square", "size": 11, "color": fill})
    if any(value is not None for value in noise):
        theme.legend_entry(figure, "noise floor", line=theme.NOISE_LINE)
    figure.update_yaxes(autorange="reversed", tickvals=list(range(len(names))), ticktext=names, ticksuffix=" ")
    return figure


def candidates(diagnosis: Diagnosis) -> go.Figure:
    """Draw the predicted share of the residual that each effect explains before the first and after the last step."""
    first, last = diagnosis.selection.first_reductions, diagnosis.selection.last_reductions
    names = sorted({*first, *last}, key=lambda name: -max(first.get(name, 0.0), last.get(name, 0.0)))[:MAX_CANDIDATES]
    added = {finding.term.name for finding in diagnosis.selection.findings}
    figure = theme.subplots(1, 1, theme.LEGEND + theme.FOOTER + 24 * len(names))
    labels = [f"<b>{theme.escaped(name)}</b>" if name in added else theme.escaped(name) for name in names]
    series = [
        ("before the first step", first, theme.CATEGORIES[1]),
        ("after the last step", last, theme.CATEGORIES[0]),
    ]
    for label, reductions, colour in series:
        shares = [100 * max(reductions.get(name, 0.0), 0.0) for name in names]
        figure.add_scatter(
            x=shares,
            y=labels,
            mode="markers",
            name=label,
            marker={"color": colour, "size": 9},
            hovertemplate=f"%{{y}}, {label}: %{{x:.2g}} %<extra></extra>",
        )
    figure.update_yaxes(autorange="reversed")
    figure.update_xaxes(title_text="share of the error that it would explain [%]", range=[-2, 104])
    return figure


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
