"""List of the cases: hidden effects, robot and recording conditions. The list is always the same."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Literal
from zlib import crc32

import numpy as np

from drivers.simulated.effect import library
from drivers.simulated.effect import out_of_library as out_of_library_effects

PlantName = Literal["simulated", "foreign"]
Kind = Literal["nothing", "single", "pair", "outside"]
RobotName = Literal["default", "heavy", "light"]

ROBOTS: tuple[RobotName, ...] = ("default", "heavy", "light")
_COMMAND_ONLY = ("amplifier_deadband", "amplifier_saturation")
"""Effects that are not visible in motor voltages."""
_NEVER_TOGETHER = {
    frozenset(("backlash", "joint_elasticity")),  # both between motor and arm, in an undefined order
    frozenset(("torque_offset", "joint_spring")),  # a spring includes an offset
}
_NOISE = (0.005, 0.01, 0.02)
_RATES = {"simulated": (200, 250, 400, 500, 800, 900), "foreign": (200, 250, 400, 500, 800, 1000)}
"""Sampling rates [Hz]; the bus of the simulated rig does not allow 1 kHz."""
_BITS = (16, 17, 18, 20)
_PAIR_SIZES = ((0.03, 0.03), (0.10, 0.03))


@dataclass(frozen=True)
class Case:
    """A pair of recordings."""

    plant: PlantName
    kind: Kind
    effects: tuple[str, ...]
    sizes: tuple[float, ...]
    """Size of each effect: its torque that the base model cannot absorb, as a share of the torque."""
    robot: RobotName
    number: int
    """Number among the cases that differ only in random values."""
    volts: float = 0.01
    """Standard deviation of the voltage's noise [V]."""
    bits: int = 18
    """Encoder resolution per turn of the joint [bit]."""
    rate: float = 500.0
    """[Hz]"""
    reports_command: bool = False

    @property
    def name(self) -> str:
        """Name of the folder, also used in tables."""
        hidden = "+".join(f"{effect}-{100 * size:g}%" for effect, size in zip(self.effects, self.sizes, strict=True))
        conditions = f"{self.robot}-{self.bits}bit-{self.rate:g}Hz" if self.kind == "nothing" else self.robot
        return "-".join(filter(None, (self.kind, hidden, conditions, str(self.number))))

    @property
    def seed(self) -> int:
        """Seed of all random values."""
        return crc32(f"{self.plant} {self.name}".encode())


def cases(plant: PlantName) -> list[Case]:
    """All cases of a plant, in a fixed random order: the first n are a representative sample."""
    ordered = list(_simulated() if plant == "simulated" else _foreign())
    order = np.random.default_rng(0).permutation(len(ordered))
    return [ordered[i] for i in order]


def _simulated() -> Iterator[Case]:
    for size, times in ((0.005, 1), (0.01, 2), (0.03, 2), (0.10, 1)):
        yield from _single_effects("simulated", library(), size, times)
    yield from _nothing("simulated", 110)
    yield from _pairs("simulated", 75)
    for size, times in ((0.03, 3), (0.10, 2)):
        yield from _single_effects("simulated", out_of_library_effects(), size, times, "outside")


def _foreign() -> Iterator[Case]:
    from tests.foreign.out_of_library import KINDS

    for size, times in ((0.01, 2), (0.03, 2), (0.10, 1)):
        yield from _single_effects("foreign", library(), size, times)
    yield from _nothing("foreign", 110)
    yield from _pairs("foreign", 75)
    yield from _single_effects("foreign", tuple(KINDS), 0.03, 3, "outside")


def _single_effects(
    plant: PlantName, effects: Sequence[str], size: float, times: int, kind: Kind = "single"
) -> Iterator[Case]:
    """Each effect, `times` times on each robot."""
    for effect in effects:
        for number in range(times * len(ROBOTS)):
            yield _case(plant, kind, (effect,), (size,), ROBOTS[number % len(ROBOTS)], number + 1)


def _pairs(plant: PlantName, count: int) -> Iterator[Case]:
    possible = [pair for pair in combinations(library(), 2) if frozenset(pair) not in _NEVER_TOGETHER]
    for number, index in enumerate(np.random.default_rng(1).permutation(len(possible))[:count]):
        first, second = possible[index]
        pair = (first, second) if number % 4 < 2 else (second, first)
        sizes = _PAIR_SIZES[number % len(_PAIR_SIZES)]
        yield _case(plant, "pair", pair, sizes, ROBOTS[number % len(ROBOTS)], number + 1)


def _nothing(plant: PlantName, count: int) -> Iterator[Case]:
    """Cases without hidden effects; half of them cover the whole range of encoder resolution and rate."""
    conditions = list(product(range(12, 21), _RATES[plant]))
    order = np.random.default_rng(4).permutation(len(conditions))
    for number in range(count):
        rng = np.random.default_rng([2, number])
        varied = number % 2 == 1
        bits, rate = conditions[order[number // 2 % len(order)]] if varied else (int(rng.choice(_BITS)), 500)
        yield Case(
            plant,
            "nothing",
            (),
            (),
            ROBOTS[number % len(ROBOTS)],
            number + 1,
            volts=float(rng.choice(_NOISE)),
            bits=bits,
            rate=float(rate),
            reports_command=bool(rng.random() < 0.5),
        )


def _case(
    plant: PlantName, kind: Kind, effects: tuple[str, ...], sizes: tuple[float, ...], robot: RobotName, number: int
) -> Case:
    rng = np.random.default_rng([3, *"".join(effects).encode(), number])
    return Case(
        plant,
        kind,
        effects,
        sizes,
        robot,
        number,
        volts=float(rng.choice(_NOISE)),
        bits=int(rng.choice(_BITS)),
        # Half of the other cases too, so that the kind of voltage does not reveal the effect.
        reports_command=bool(set(effects) & set(_COMMAND_ONLY)) or bool(rng.random() < 0.5),
    )
