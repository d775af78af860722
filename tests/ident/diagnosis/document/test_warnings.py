"""Warnings of a diagnosis about its recordings."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.document.warnings import data_warnings
from recordings.rig import simulated_rig


def _warnings(
    standstill_share: float = 0.0,
    unjudged_shares: tuple[float, ...] = (),
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
    split: Any = SimpleNamespace(
        independent_rows=rows,
        standstill_share=standstill_share,
        unjudged_shares=unjudged_shares,
        other_motion=False,
        recordings=(data,),
        predictors=(SimpleNamespace(prepared=data),),
        train=(np.ones((10, 3), bool),),
        test=(np.zeros((10, 3), bool),),
    )
    model: Any = SimpleNamespace(solution=SimpleNamespace(x=np.zeros(10)), residuals=(np.zeros((10, 3)),))
    return " ".join(data_warnings(split, model, SimpleNamespace(rms=np.ones(3), known=True)))  # type: ignore[arg-type]


def test_good_recordings_have_no_warnings() -> None:
    assert _warnings() == ""


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"standstill_share": 0.08}, "8% of the rows are left out"),
        ({"unjudged_shares": (0.0, 0.44, 0.113)}, "44.0% (joint 2) and 11.3% (joint 3) are not scored"),
        ({"gain_source": "assumed"}, "assumed, with an uncertainty of 10%"),
        ({"rows": 150.0}, "Too short: 150 independent rows for 10 parameters"),
        ({"complete": False}, "Truncated: run.mcap"),
    ],
)
def test_excluded_rows_short_recordings_and_assumed_gain_are_reported(given: dict[str, Any], expected: str) -> None:
    assert expected in _warnings(**given)
