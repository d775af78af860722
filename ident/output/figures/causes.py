"""Draw the torque by its causes: stacked over one repetition, and the RMS of each."""

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np
import plotly.graph_objects as go

from delta_web.palette import CAUSES
from ident.output.figures import theme
from recordings.recording import Floats

_HEIGHT = 190
"""Of the plots of one joint [px]."""


def stacked(
    time: Floats, torque: Floats, terms: Mapping[str, Floats], rms: Mapping[str, Floats], units: Sequence[str]
) -> go.Figure:
    """Draw one row for each joint; what is positive is stacked upwards, what is negative downwards.

    time: (n,) [s]; torque and terms: (n, dof); rms: (dof,) of each cause.
    """
    dof = torque.shape[1]
    figure = theme.subplots(
        dof,
        2,
        theme.LEGEND + theme.FOOTER + _HEIGHT * dof,
        column_widths=[0.74, 0.26],
        horizontal_spacing=0.16,
        vertical_spacing=0.24 / dof,
    )
    names = list(terms)
    colours = {name: CAUSES[k % len(CAUSES)] for k, name in enumerate(names)}
    for joint in range(dof):
        place = {"row": joint + 1, "col": 1}
        for name, (side, part) in product(names, (("up", np.maximum), ("down", np.minimum))):
            figure.add_scatter(
                x=time,
                y=part(terms[name][:, joint], 0.0),
                name=theme.escaped(name),
                legendgroup=name,
                showlegend=joint == 0 and side == "up",
                stackgroup=f"{side} {joint}",
                line={"width": 0, "color": colours[name]},
                hoverinfo="skip",
                **place,
            )
        line = {"color": theme.MEASURED, "width": 2}
        figure.add_scatter(x=time, y=torque[:, joint], name="torque", line=line, showlegend=joint == 0, **place)
        figure.add_bar(
            x=[rms[name][joint] for name in names],
            y=[theme.escaped(name) for name in names],
            orientation="h",
            marker_color=[colours[name] for name in names],
            showlegend=False,
            row=joint + 1,
            col=2,
        )
        figure.update_yaxes(title_text=f"{theme.joint_title(joint)}<br>{theme.effort_label(units[joint])}", **place)
        figure.update_yaxes(autorange="reversed", row=joint + 1, col=2)
    figure.update_xaxes(title_text="time [s]", row=dof, col=1)
    figure.update_xaxes(title_text=f"RMS [{units[-1]}]", row=dof, col=2)
    return figure
