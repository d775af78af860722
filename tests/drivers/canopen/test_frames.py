"""Every frame of set-up, first cycle and shut-down, per dictionary: what is sent, and what comes back.

`python -m tests.drivers.canopen.test_frames` writes the files anew: look at their differences.
"""

import tempfile
from pathlib import Path
from typing import Any

import can
import pytest

from daq.proposal.document import propose
from daq.proposal.facts import from_file
from drivers.protocol import Goal, Power
from recordings.errors import BadInput, RunFailed
from recordings.rig import CanBus, Rig, load_rig
from tests.daq.proposal.test_rig_command import REAL, REFUSED, SHARED, decide
from tests.drivers.canopen.lossy_bus import LossyBus, reach
from tests.drivers.canopen.made_up_runs import bus_of, rig_of
from tests.drivers.simulated.dictionaries import MADE_UP

FRAMES = Path(__file__).with_name("frames")
RIGS: dict[str, tuple[float, dict[str, Any]]] = {
    "wilful": (500.0, {"accept_missing": ["6066"], "homed": {"index": 0x6041, "mask": 0x8000}}),
    "wide_voltage": (500.0, {}),
    "one_millisecond": (1000.0, {"counts_per_turn": 360_000}),
    "profile_only": (500.0, {}),
    "slow": (500.0, {}),
    "unset_factors": (500.0, {}),
    "older_speed": (500.0, {"units": {"acceleration": "counts/s^2"}}),
}
"""Rate and keys of the rig file for each dictionary."""
DRIVEN = (*RIGS, *(name for name in REAL if name not in REFUSED))


def bus_with(name: str) -> tuple[Rig, LossyBus]:
    """The rig file for a drive, and a bus with it; for the dictionary of a real drive, the file that is proposed."""
    if name in RIGS:
        rate, keys = RIGS[name]
        rig = rig_of(MADE_UP[name], rate, **keys)
        return rig, bus_of(MADE_UP[name], rig)
    if not (SHARED / name).exists():
        pytest.skip(f"{name} is not here; set REAL_DATA")
    proposal = propose([from_file(SHARED / name, 1)], CanBus(interface="virtual", channel=name))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "rig.toml"
        path.write_text(proposal.text)
        decide(path)
        rig = load_rig(path)
    return rig, LossyBus(rig, SHARED / name)


def frames_of(rig: Rig, bus: LossyBus) -> list[str]:
    """Lines "sent > received received ..."; a drive's frames stand behind the one that they follow."""
    driver, lines = bus.driver(), list[str]()

    def note(_: int, message: can.Message, sent: bool) -> None:
        text = f"{message.arbitration_id:03X} {bytes(message.data).hex(' ')}".strip()
        if sent:
            lines.append(f"{text} >")
        elif lines:
            lines[-1] += f" {text}"

    driver._link.tap = note
    try:
        driver.discover()
        driver.configure()
        for goal, power in ((Goal.ENABLED, Power.ON), (Goal.STOPPED, Power.OFF)):
            reach(driver, goal, power)
    except (BadInput, RunFailed) as error:
        lines.append(str(error))
    driver.close()
    assert not bus.enabled
    return lines


@pytest.mark.parametrize("name", DRIVEN)
def test_every_frame_is_the_kept_one(name: str) -> None:
    assert {*RIGS, "outputs_only"} == set(MADE_UP)
    assert frames_of(*bus_with(name)) == (FRAMES / f"{name}.txt").read_text().splitlines()


if __name__ == "__main__":
    for dictionary in DRIVEN:
        (FRAMES / f"{dictionary}.txt").write_text("\n".join(frames_of(*bus_with(dictionary))) + "\n")
