"""Figure of a trajectory: every joint, limits in view, one repetition."""

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from delta_web.palette import JOINTS
from recordings.rig import simulated_rig
from tests.trajectories.test_checks import limited
from trajectories import load
from trajectories.drawing import LIMIT, draw

RIG = simulated_rig()


def panel(figure: Figure, title: str) -> Axes:
    return next(axes for axes in figure.axes if axes.get_title(loc="left").startswith(title))


@pytest.mark.parametrize(
    ("title", "attribute"),
    [("angle", "joint_position"), ("speed", "joint_velocity"), ("acceleration", "joint_acceleration")],
)
def test_each_joint_is_drawn_from_lead_in_to_the_end_of_one_repetition(title: str, attribute: str) -> None:
    trajectory = load("fig5a", RIG)
    axes = panel(draw(trajectory, RIG), title)
    lines = axes.get_lines()
    assert [line.get_color() for line in lines] == list(JOINTS[:3])
    for joint, line in enumerate(lines):
        drawn = np.asarray(line.get_ydata())
        assert (drawn == getattr(trajectory, attribute)[: len(drawn), joint]).all()
        assert len(drawn) == (1 + trajectory.period) * trajectory.rate + 1


def test_limit_is_a_line_where_in_view_and_always_in_the_title() -> None:
    trajectory = load("fig5a", RIG)
    far, near = (panel(draw(trajectory, rig), "speed") for rig in (RIG, limited(speed=3.0)))
    assert [line.get_ydata()[0] for line in near.get_lines() if line.get_color() == LIMIT] == [-3.0, 3.0]
    assert LIMIT not in [line.get_color() for line in far.get_lines()]
    assert far.get_title(loc="right").endswith("limit ±12")
    assert near.get_title(loc="right").endswith("limit ±3")
