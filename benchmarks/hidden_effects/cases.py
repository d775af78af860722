"""One case of the benchmark: what is hidden, in which robot, recorded under which conditions."""

from dataclasses import dataclass
from typing import Literal
from zlib import crc32

from drivers.simulated.effect import library

PlantName = Literal["simulated", "foreign"]
Part = Literal["tuned", "chosen", "locked"]
Kind = Literal["nothing", "single", "pair", "outside", "added"]
RobotName = Literal["default", "heavy", "light", "any"]
Signal = Literal["voltage", "effort"]

ADDED = (
    "directional_load_friction",
    "passive_joint_friction",
    "self_heating",
    "stribeck_load_friction",
)
"""Single effects that came later: cases of a kind of their own, drawn last, so that all others stay the same."""
COMMAND_ONLY = ("amplifier_deadband", "amplifier_saturation")
"""Effects that are not visible in motor voltages."""
VOLTAGE_ONLY = (*COMMAND_ONLY, "back_emf", "torque_gain_mismatch", "torque_map_exponent")
"""Effects that are not visible in efforts."""
_OF_POSITION = ("torque_offset", "joint_spring", "arm_com_offset", "arm_mass_mismatch", "base_tilt")
"""Effects of the position alone."""
NEVER_TOGETHER = {
    frozenset(("backlash", "joint_elasticity")),  # both between motor and arm, in an undefined order
    frozenset(("torque_offset", "joint_spring")),  # a spring includes an offset
    # a curve over the position includes these
    *(frozenset((each, "position_torque")) for each in _OF_POSITION),
}
NOISE = (0.005, 0.01, 0.02)
"""Standard deviations of the noise of the voltage [V]."""
BITS = (16, 17, 18, 20)
"""Encoder resolutions [bit]."""
PAIR_SIZES = ((0.03, 0.03), (0.10, 0.03))


def drawn_effects() -> tuple[str, ...]:
    """Names of the effects in the list that all kinds but `added` are drawn from."""
    return tuple(name for name in library() if name not in ADDED)


@dataclass(frozen=True)
class HiddenCase:
    """A pair of recordings, and what is hidden in it."""

    plant: PlantName
    kind: Kind
    effects: tuple[str, ...]
    sizes: tuple[float, ...]
    """Size of each effect: its torque that the base model cannot absorb, as a share of the torque."""
    robot: RobotName
    number: int
    """Number among the cases that differ only in random values."""
    part: Part = "tuned"
    digest: str = ""
    """Digest that a case of the locked part is drawn from."""
    volts: float = 0.01
    """Standard deviation of the voltage's noise [V]."""
    bits: int = 18
    """Encoder resolution per turn of the joint [bit]."""
    rate: float = 500.0
    """[Hz]"""
    reports_command: bool = False
    repeats: bool = True
    """Whether the motions consist of identical cycles."""
    signal: Signal = "voltage"
    """What the drives report."""
    signal_bits: int | None = None
    """Resolution of this signal [bit]; None: no steps."""

    @property
    def name(self) -> str:
        """Name of the folder, also used in tables."""
        hidden = "+".join(f"{effect}-{100 * size:g}%" for effect, size in zip(self.effects, self.sizes, strict=True))
        if self.part != "tuned":
            return "-".join(filter(None, (self.part, self.digest, self.kind, hidden, str(self.number))))
        conditions = f"{self.robot}-{self.bits}bit-{self.rate:g}Hz" if self.kind == "nothing" else self.robot
        return "-".join(filter(None, (self.kind, hidden, conditions, str(self.number))))

    @property
    def seed(self) -> int:
        """Seed of all random values."""
        return crc32(f"{self.plant} {self.name}".encode())
