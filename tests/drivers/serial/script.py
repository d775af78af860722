"""Scripts of commands and replies for three drives on one serial line."""

import math

from drivers.protocol import Goal, Power, Sample
from drivers.serial.drive import SerialDrives
from recordings.buses import SerialBus
from recordings.rig import Drive, Rig
from tests.drivers.serial.scripted_port import Exchange, ScriptedPort, line_on

_LACKS = ("watchdog",)
DRIVES = (
    Drive(node_id=1, counts_per_turn=1000, gear=math.tau, accept_missing=_LACKS),
    Drive(node_id=2, counts_per_turn=1000, gear=math.tau, accept_missing=_LACKS, sign=-1, zero_offset=0.5),
    Drive(node_id=3, counts_per_turn=1000, gear=math.tau, accept_missing=_LACKS),
)
"""1000 counts per radian; voltage 0.5 mV per count; no watchdog, which is accepted."""
RIG = Rig(name="test", rate=20.0, bus=SerialBus(ports=("line",)), drives=DRIVES)

OFF, ON, MOVING, FAULT = 0x8000, 0, 0x0800_0000, 0x0040_8000
Log = list[tuple[str, str, str]]

FLUSH: Exchange = ("", "e 33")
ENDS = {1: (-1200, 1400), 2: (-900, 1700), 3: (-1200, 1400)}
"""Position limits of each drive [counts]; the second one has the opposite sign."""


def drives(script: list[Exchange], rig: Rig = RIG) -> tuple[SerialDrives, ScriptedPort, Log]:
    """Drives with unknown states."""
    port, log = ScriptedPort(script), Log()
    lines = {"line": line_on(port)}
    return SerialDrives(rig, lines, lambda *entry: log.append(entry), stamped=False), port, log


def read(node: int, counts: int = 0, volts: int = 0) -> list[Exchange]:
    return [(f"{node} g r0x32", f"v {counts}"), (f"{node} g r0x15", f"v {volts}")]


def status(node: int, word: int) -> Exchange:
    return f"{node} g r0xa0", f"v {word}"


def move(node: int, counts: int) -> list[Exchange]:
    return [(f"{node} s r0xca {counts}", "ok"), (f"{node} t 1", "ok")]


def cycle(
    status_node: int, commands: dict[int, list[Exchange]] | None = None, word: int = OFF, counts: int = 0
) -> list[Exchange]:
    """One cycle: commands to each drive, status of `status_node`, measured values of all drives."""
    script: list[Exchange] = []
    for node in (1, 2, 3):
        script += [
            *(commands or {}).get(node, []),
            *([status(node, word)] if node == status_node else []),
            *read(node, counts),
        ]
    return script


def off(node: int) -> Exchange:
    return f"{node} s r0x24 0", "ok"


def enable(node: int, counts: int = 0) -> list[Exchange]:
    return [(f"{node} s r0xca {counts}", "ok"), (f"{node} s r0x24 21", "ok")]


RELEASED = [
    *cycle(1, {1: [off(1)], 2: [off(2)], 3: [off(3)]}),
    *cycle(2, {2: [off(2)], 3: [off(3)]}),
    *cycle(3, {3: [off(3)]}),
]
"""First commands to the drives: power off, until the status shows it."""
ENABLED = [*RELEASED, *(pair for node in (1, 2, 3) for pair in cycle(node, {node: enable(node)}, word=ON))]


def run(amplifiers: SerialDrives, goals: dict[Goal, int]) -> Sample:
    """The last sample of so many exchanges with each goal."""
    for goal, count in goals.items():
        amplifiers.goal = goal
        for _ in range(count):
            sample = amplifiers.exchange(None, 1.0)
    return sample


def enabled(script: list[Exchange]) -> tuple[SerialDrives, ScriptedPort, Log]:
    """Enabled drives, with the script that follows."""
    amplifiers, port, log = drives([*ENABLED, *script])
    sample = run(amplifiers, {Goal.DISABLED: 3, Goal.ENABLED: 3})
    assert sample.power == (Power.ON,) * 3
    return amplifiers, port, log


def setup(node: int, low: int, high: int) -> list[Exchange]:
    """Limits of 0.05 rad, 150 rad/s^2, -1.2 and 1.4 rad."""
    table = [("r0xba", 50), ("r0xcf", 15000), ("r0xb8", high), ("r0xb9", low), ("r0xc8", 0)]
    return [
        pair
        for name, value in table
        for pair in ((f"{node} s {name} {value}", "ok"), (f"{node} g {name}", f"v {value}"))
    ]


def configured(node: int, low: int, high: int) -> list[Exchange]:
    return [off(node), (f"{node} g r0xa4", "v 0"), (f"{node} g r0xa4", "v 0"), *setup(node, low, high)]


SET_UP = [x for node, ends in ENDS.items() for x in [*configured(node, *ends), status(node, OFF)]]
