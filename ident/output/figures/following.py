"""Draw the following error of several runs of one motion over each other."""

from collections.abc import Mapping

import plotly.graph_objects as go

from ident.output.figures import theme
from recordings.recording import Recording

_HEIGHT = 150
"""Of the plot of one joint [px]."""
_POINTS = 1500
"""Points of a line, at most."""


def over_time(runs: Mapping[str, Recording]) -> go.Figure:
    """Draw one row for each joint, with the following error of each run [mrad or mm] during its repetitions."""
    first = next(iter(runs.values()))
    dof, units = first.rig.dof, first.rig.position_units
    figure = theme.subplots(
        dof, 1, theme.LEGEND + theme.FOOTER + _HEIGHT * dof, shared_xaxes=True, vertical_spacing=0.12 / dof
    )
    for number, (name, recording) in enumerate(runs.items()):
        moving = recording.repeat >= 0
        time, error = recording.time[moving], 1e3 * recording.following_error[moving]
        line = {"color": theme.MEASURED if number == 0 else theme.joint_colour(number - 1), "width": 1.5}
        for joint in range(dof):
            xs, ys = theme.thinned(time - time[:1], error[:, joint], _POINTS)
            figure.add_scatter(
                x=xs, y=ys, name=name, legendgroup=name, line=line, showlegend=joint == 0, row=joint + 1, col=1
            )
    for joint, unit in enumerate(units, start=1):
        figure.update_yaxes(title_text=f"{theme.joint_title(joint - 1)}<br>[m{unit}]", row=joint, col=1)
    figure.update_xaxes(title_text="time [s]", row=dof, col=1)
    return figure
