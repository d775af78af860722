"""Figures of the page: every recording at a glance, and trends by joint with the dates of alarms."""

from collections.abc import Callable
from datetime import datetime

import numpy as np
import pyarrow as pa

from ident.fleet import figures
from ident.fleet.recording_rows import Row
from ident.fleet.series import nights_and_series


def test_glance_and_trends(rows: Callable[..., list[Row]], table: Callable[[list[Row]], pa.Table]) -> None:
    made = rows("r1", {"c_c1": np.ones(5), "c_c2": np.ones(5), "c_v1": np.ones(5)})
    nights, series = nights_and_series(table(made))
    glance = figures.glance(nights, [("r2", datetime(2026, 1, 6))], ())
    assert [(trace.name, len(trace.x)) for trace in glance.data] == [("cannot be used", 1), ("as before", 5)]
    trends = figures.trends(series, (), ())
    assert [annotation.text for annotation in trends.layout.annotations] == ["c_c [N m]", "c_v [N m]"]
    assert [trace.name for trace in trends.data] == ["joint 1", "joint 2", "joint 1"]
    assert [trace.showlegend for trace in trends.data] == [True, True, False]
