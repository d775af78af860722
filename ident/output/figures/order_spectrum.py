"""Draw the residual above the low-pass by periods per turn, without the ripple that was found and with it."""

import plotly.graph_objects as go

from ident.diagnosis.ripple.ripple import Ripple
from ident.output.figures import theme


def order_spectrum(ripple: Ripple) -> go.Figure:
    """Draw the amplitude over the order for each joint with lines; the orders found are marked."""
    joints = sorted({line.joint for line in ripple.lines})
    figure = theme.subplots(
        1,
        len(joints),
        320,
        shared_yaxes="all",
        subplot_titles=[theme.joint_title(j) for j in joints],
        horizontal_spacing=0.04,
    )
    rig = ripple.model.split.recordings[0].recording.rig
    for column, joint in enumerate(joints, start=1):
        for with_lines, name, colour in (
            (False, "without it", theme.MEASURED),
            (True, "with it", theme.joint_colour(joint)),
        ):
            orders, amplitude = ripple.order_spectrum(joint, with_lines)
            x, y = theme.thinned(orders, amplitude)
            style = {"color": colour, "width": 1.5}
            figure.add_trace(
                go.Scatter(x=x, y=y, name=name, line=style, legendgroup=name, showlegend=column == 1),
                row=1,
                col=column,
            )
        for line in ripple.lines:
            if line.joint == joint:
                figure.add_annotation(
                    x=line.order,
                    y=line.amplitude,
                    text=f"{line.order:.5g}",
                    showarrow=False,
                    yshift=10,
                    row=1,
                    col=column,
                )
        figure.update_xaxes(title_text="periods per turn", row=1, col=column)
    figure.update_yaxes(title_text=f"amplitude [{rig.effort_units[joints[0]]}]", row=1, col=1)
    return figure
