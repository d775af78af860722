"""What happens to a fleet: its robots, temperatures, hidden events, missing nights, broken files and wrong clocks."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from recordings.recording import Floats
from tests.foreign.out_of_library import KINDS

Fault = Literal["truncated", "random", "empty", "text", "undated", "future"]
FAULTS: tuple[Fault, ...] = ("truncated", "random", "empty", "text", "undated", "future")
EXCHANGED_DRIVE = "torque_gain_mismatch"
"""What the exchange of a drive leaves in the recordings: another gain of its torque."""
SUDDEN = (
    "load_dependent_friction",
    "stribeck",
    "cogging",
    EXCHANGED_DRIVE,
    "encoder_zero_offset",
    "torque_offset",
    "quadratic_friction",
    "joint_spring",
)
"""Effects that appear from one night to the next."""
OUTSIDE = tuple(KINDS)
"""Effects that no library has: an alarm has to say that it is of an unknown one."""
GROWING = ("load_dependent_friction", "position_dependent_friction", "asymmetric_viscous", "joint_spring")
_QUIET = 10
"""Nights of each robot without an event: its baseline; fewer in a short fleet, a third of all nights."""
_SIZES = (0.02, 0.05)
"""Range of the final size of an effect, as a share of the torque."""
_MISSING, _BROKEN, _OTHER_MOTION = 0.06, 0.04, 0.12
"""Shares of nights without a recording, with a broken file, and with another motion than usual."""
_WRONG_CLOCK, _CLOCK_ERROR = 0.02, 3.0
"""Share of nights whose clock had jumped, and by how much at most [days]."""
_SEASON, _WARM_UP, _DAILY = 6.0, 8.0, 1.0
"""Amplitude of the season, warm-up by work, and standard deviation of the rest [degC]."""
_YEAR = 365.25


@dataclass(frozen=True)
class PlannedEvent:
    """An effect that appears on one robot."""

    robot: int
    effect: str
    joint: int
    """From 1."""
    night: int
    """The first with the effect."""
    growing: bool
    """Whether it grows steadily from there to its size, which it reaches in the last night."""
    size: float

    def share(self, night: int, nights: int) -> float:
        """Share of its size in this `night`."""
        if night < self.night:
            return 0.0
        return (night - self.night + 1) / (nights - self.night) if self.growing else 1.0


@dataclass(frozen=True, eq=False)
class FleetPlan:
    """A fleet of R robots over N nights."""

    seed: int
    robots: int
    nights: int
    events: tuple[PlannedEvent, ...]
    missing: frozenset[tuple[int, int]]
    """Robots and nights without a recording."""
    faults: dict[tuple[int, int], Fault]
    """Broken files, by robot and night."""
    other_motion: frozenset[tuple[int, int]]
    clock: dict[tuple[int, int], float]
    """Error of the clock, by robot and night [days]."""
    temperature: Floats
    """(R, N) of the drives [degC]."""


def draw(seed: int, robots: int, nights: int, events: int, outside: bool = False) -> FleetPlan:
    """Draw a fleet with so many `events`, each on another robot as far as there are enough.

    Every third one grows; the second is a drive that is exchanged. outside: instead each is an effect of OUTSIDE.
    """
    rng = np.random.default_rng([seed, robots, nights])
    quiet = min(_QUIET, nights // 3)
    order = [int(robot) for _ in range(-(-events // robots)) for robot in rng.permutation(robots)][:events]
    drawn = tuple(_draw_event(rng, robot, index, quiet, nights, outside) for index, robot in enumerate(order))
    cells = [(robot, night) for robot in range(robots) for night in range(nights)]
    missing = frozenset(cell for cell in cells if rng.random() < _MISSING)
    broken = {cell: FAULTS[rng.integers(len(FAULTS))] for cell in cells if rng.random() < _BROKEN}
    other = frozenset(cell for cell in cells if rng.random() < _OTHER_MOTION)
    clock = {cell: float(rng.uniform(-_CLOCK_ERROR, _CLOCK_ERROR)) for cell in cells if rng.random() < _WRONG_CLOCK}
    return FleetPlan(seed, robots, nights, drawn, missing, broken, other, clock, _temperature(rng, robots, nights))


def _temperature(rng: np.random.Generator, robots: int, nights: int) -> Floats:
    """(R, N) of the drives [degC]: season, place, and warm-up by the work before, from none to that of a long day."""
    season = 20 + _SEASON * np.sin(2 * np.pi * (np.arange(nights) / _YEAR + rng.random()))
    place = rng.uniform(0, 4, robots)[:, None]
    warm_up = _WARM_UP * (1 - np.exp(-rng.exponential(1.0, (robots, nights))))
    return season + place + warm_up + rng.normal(0, _DAILY, (robots, nights))


def _draw_event(
    rng: np.random.Generator, robot: int, index: int, quiet: int, nights: int, outside: bool
) -> PlannedEvent:
    growing = index % 3 == 2
    effects: tuple[str, ...] = GROWING if growing else (EXCHANGED_DRIVE,) if index == 1 else SUDDEN
    if outside:
        effects = (OUTSIDE[index % len(OUTSIDE)],)
    last = nights - max(nights // 2, 5) if growing else nights - 4
    return PlannedEvent(
        robot=robot,
        effect=effects[rng.integers(len(effects))],
        joint=int(rng.integers(1, 4)),
        night=int(rng.integers(quiet, max(last, quiet + 1))),
        growing=growing,
        size=float(rng.uniform(*_SIZES)),
    )
