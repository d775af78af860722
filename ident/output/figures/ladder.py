"""How the error fell, effect by effect, and what each effect promised."""

from collections.abc import Sequence

import plotly.graph_objects as go

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document import Document, StepEntry
from ident.output.figures import theme

MOST = 14
"""Candidates that are shown."""


def ladder(document: Document) -> go.Figure:
    """Training and held-out RMS of each rung, joint by joint, and the noise floor as the line to reach."""
    names = [theme.escaped(label) for label in document.labels]
    return rms_bars(names, document.rungs, document.noise_rms, document.effort_units)


def rms_bars(names: Sequence[str], rungs: Sequence[StepEntry], noise: Sequence[float], units: Sequence[str]) -> go.Figure:
    """The same of any models, `rungs`, called `names`; `noise` and `units` of the joints."""
    dof = len(units)
    figure = theme.subplots(
        1,
        dof,
        theme.HEADER + theme.FOOTER + 20 + 58 * len(names),
        shared_yaxes=True,
        subplot_titles=theme.joint_titles(dof),
        horizontal_spacing=0.03,
    )
    for joint in range(dof):
        colour = theme.joint_colour(joint)
        unit = units[joint]
        sides = [
            ("training", [rung.train_rms[joint] for rung in rungs], theme.with_opacity(colour, theme.FAINT_OPACITY)),
            ("held out", [rung.validate_rms[joint] for rung in rungs], colour),
        ]
        for label, values, fill in sides:
            drawn = go.Bar(
                x=values,
                y=list(range(len(names))),
                orientation="h",
                name=label,
                text=[theme.number(value, 2) for value in values],
                textposition="outside",
                cliponaxis=False,
                marker_color=fill,
                showlegend=False,
                hovertemplate=f"{label}: %{{x:.3g}} {unit}<extra></extra>",
            )
            figure.add_trace(drawn, row=1, col=joint + 1)
        most = max(max(rung.train_rms[joint], rung.validate_rms[joint]) for rung in rungs)
        line = {"color": theme.NOISE, "width": 2, "dash": "dash"}
        figure.add_vline(x=noise[joint], line=line, row=1, col=joint + 1)
        figure.update_xaxes(title_text=f"RMS error [{unit}]", range=[0, 1.22 * most], row=1, col=joint + 1)
    square = {"symbol": "square", "size": 11}
    theme.legend_entry(figure, "training", marker=square | {"color": theme.with_opacity(theme.MEASURED, theme.FAINT_OPACITY)})
    theme.legend_entry(figure, "held out", marker=square | {"color": theme.MEASURED})
    theme.legend_entry(figure, "noise floor", line={"color": theme.NOISE, "width": 2, "dash": "dash"})
    figure.update_yaxes(autorange="reversed", tickvals=list(range(len(names))), ticktext=names, ticksuffix=" ")
    return figure


def candidates(found: Diagnosis) -> go.Figure:
    """What each effect would explain, at first sight, of what the base model left, and of what is left at the end."""
    first, last = found.selection.first_extensions.loss_reductions, found.selection.last_extensions.loss_reductions
    names = sorted({*first, *last}, key=lambda name: -max(first.get(name, 0.0), last.get(name, 0.0)))[:MOST]
    added = {one.term.name for one in found.selection.findings}
    figure = theme.subplots(1, 1, theme.LEGEND + theme.FOOTER + 24 * len(names))
    labels = [f"<b>{theme.escaped(name)}</b>" if name in added else theme.escaped(name) for name in names]
    sides = [("at first", first, theme.JOINTS[0]), ("at the end, of what is left", last, theme.JOINTS[3])]
    for label, gains, colour in sides:
        shares = [100 * max(gains.get(name, 0.0), 0.0) for name in names]
        dots = go.Scatter(
            x=shares,
            y=labels,
            mode="markers",
            name=label,
            marker={"color": colour, "size": 9},
            hovertemplate=f"%{{y}}, {label}: %{{x:.2g}} %<extra></extra>",
        )
        figure.add_trace(dots)
    figure.update_yaxes(autorange="reversed")
    figure.update_xaxes(title_text="share of the error that it would explain [%]", range=[-2, 104])
    return figure
