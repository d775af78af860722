"""What must be known before the figures of a diagnosis are believed."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.warnings import data_warnings
from recordings.rig import simulated_rig


def _said(
    still: float = 0.0,
    silent: float = 0.0,
    gain_source: str = "calibrated",
    rows: float = 1000.0,
    complete: bool = True,
) -> str:
    rig = simulated_rig()
    torque = rig.torque.model_copy(update={"gain_source": gain_source, "gain_uncertainty": 0.1})
    recording = SimpleNamespace(rig=rig.model_copy(update={"torque": torque}), effort=None)
    recording.path, recording.complete = Path("run.mcap"), complete
    moving = np.resize([1.0, -1.0], (10, 1)) * np.ones((10, 3))
    data = SimpleNamespace(recording=recording, motion=SimpleNamespace(velocity=moving))
    material: Any = SimpleNamespace(
        independent_rows=rows,
        still=still,
        silent=silent,
        other_motion=False,
        datasets=(data,),
        evaluators=(SimpleNamespace(course=SimpleNamespace(dataset=data)),),
        seen=(np.ones((10, 3), bool),),
        held=(np.zeros((10, 3), bool),),
    )
    state: Any = SimpleNamespace(solution=SimpleNamespace(x=np.zeros(10)), residuals=(np.zeros((10, 3)),))
    return " ".join(data_warnings(material, state, SimpleNamespace(rms=np.ones(3)), None))  # type: ignore[arg-type]


def test_nothing_is_said_where_there_is_no_doubt() -> None:
    assert _said() == ""


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"still": 0.08}, "8% of the rows are left out"),
        ({"silent": 0.041}, "4.1% of the rows are not judged"),
        ({"gain_source": "assumed"}, "assumed, to 10%"),
        ({"rows": 150.0}, "Too short to tell: 150 independent rows for 10 parameters"),
        ({"complete": False}, "cut off: run.mcap"),
    ],
)
def test_what_no_error_is_of_and_a_gain_that_nobody_measured_are_said(given: dict[str, Any], expected: str) -> None:
    assert expected in _said(**given)
