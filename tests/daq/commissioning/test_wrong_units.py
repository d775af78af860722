"""Simulated machines that are not what the rig file says: the axis check names what is wrong, and the right value."""

import json
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from daq.bench import Bench
from daq.commissioning.axis_check import changes, judge
from daq.commissioning.axis_swings import AxisSwings
from daq.simulation import simulated
from drivers.simulated.config import SimConfig
from recordings.rig import Axis, Rig, simulated_rig

RIG = simulated_rig().at_rate(100.0)
Keys = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class WrongBench(Bench):
    """A machine that need not be what the rig file says."""

    true: Rig
    config: SimConfig

    @contextmanager
    def serve(self, recording: Path | None = None) -> Iterator[None]:
        with simulated(self.true, self.config, self.pace, 0):
            yield


def rig_with(**keys: Any) -> Rig:
    """The rig of the simulation, with keys of every drive."""
    document = RIG.model_dump(mode="json")
    document["drives"] = [drive | keys for drive in document["drives"]]
    return Rig.model_validate_json(json.dumps(document))


def checked(rig: Rig, true: Rig, sim: Keys, joint: int) -> tuple[dict[str, str], dict[str, str]]:
    """Verdict of each quantity, and proposed values by key."""
    bench = WrongBench(rig, "lockstep", true=true, config=SimConfig.model_validate_json(json.dumps(sim)))
    (figures,) = AxisSwings(bench, 0.05).figures([joint], None, None)
    results = list(judge(figures, rig))
    proposed = {change.key: change.value for change in changes([(figures, results)], rig)}
    return {result.what: result.verdict for result in results}, proposed


def habits(**keys: Any) -> Keys:
    return {"drives": [{"habits": keys}]}


TRAVEL, SIGN = "true travel, by inertia over weight", "direction of the joint"
STOP, SPEED = "unit of the quick stop", "unit of 606Ch"
COUNTS_PER_TURN = 8192
WRONG: dict[str, tuple[Keys, Keys, Keys, str, float | None]] = {
    **{f"sign of joint {joint}": ({}, {"sign": -1}, {}, SIGN, -1) for joint in (1, 2, 3)},
    **{f"counts {n}": ({}, {"counts_per_turn": n}, {}, TRAVEL, n) for n in (2048, 4096, 16384)},
    **{f"gear {gear}": ({}, {"gear": gear}, {}, TRAVEL, COUNTS_PER_TURN * gear / 21) for gear in (10.5, 42.0)},
    **{f"gain {gain}": ({}, {}, {"torque_gain": [gain] * 3}, "weight", gain) for gain in (0.25, 0.3, 0.4, 2.5, 4.0)},
    **{
        f"voltage by {factor}": ({}, {}, habits(voltage_scale=0.0005 * factor), "weight", factor**2)
        for factor in (0.5, 2)
    },
    # Nothing states the unit; the drive counts in increments.
    **{
        f"acceleration in {unit}": ({"units": {"acceleration": unit}}, {}, habits(values={"60AA": 0}), STOP, factor)
        for unit, factor in (
            ("rpm/s", 60 / COUNTS_PER_TURN),
            ("deg/s^2", 360 / COUNTS_PER_TURN),
            # So soft a stop is hardly one: its size cannot be measured.
            ("rev/s^2", None),
            ("rad/s^2", None),
        )
    },
    **{f"606Ch by {factor}": ({}, {}, habits(velocity_factor=factor), SPEED, None) for factor in (60, 0.105)},
}
"""Keys of the rig file and of the true machine, sim file, what is wrong, and the value that would be right."""


@pytest.mark.slow
@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_named_with_what_would_be_right(name: str) -> None:
    own, true, sim, what, right = WRONG[name]
    joint = int(name[-1]) if name.startswith("sign") else 1
    verdicts, proposed = checked(rig_with(**own), rig_with(**true), sim, joint)
    assert [quantity for quantity, verdict in verdicts.items() if verdict == "problem"] == [what]
    numbers = [float(re.findall(r"-?[\d.]+", value)[0]) for value in proposed.values()]
    assert numbers == ([] if right is None else [pytest.approx(right, rel=0.1)])


TORQUE = {"torque_source": "torque_actual"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "rig",
    [
        RIG,
        rig_with(mode="interpolated"),
        rig_with(**TORQUE),
        rig_with(sign=-1, gear=30.0, counts_per_turn=4096),
        # Without masses: nothing says what it should weigh.
        rig_with(**TORQUE).model_copy(update={"mechanism": "axes", "axes": (Axis(),) * 3}),
    ],
    ids=["delta", "mode 7", "torque", "other drives", "axes"],
)
def test_nothing_contradicts_a_rig_file_that_is_right(rig: Rig) -> None:
    true = rig.model_copy(update={"mechanism": "delta"})
    verdicts, proposed = checked(rig, true, {}, 2)
    assert "problem" not in verdicts.values()
    assert not proposed
    assert (verdicts.get("weight and inertia") == "not shown") == (rig.mechanism == "axes")
