"""Delta robots of three sizes, and of any size, with random parameters, and their rig files."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from drivers.simulated.config import Friction, Links
from recordings.rig import Drive, Geometry, Rig, Torque, Voltage

Kind = Literal["default", "heavy", "light", "any"]
_SPREAD = 0.1
"""Largest relative deviation of masses, inertias and friction from those of the kind."""
_SCALE = 1.5
"""Largest factor between the lengths of a robot of any size and those of its kind; masses and friction differ by its
square at most."""
_PROPORTION = 0.04
"""Largest relative deviation of a length from that factor."""
_TABLE_1 = Links()


@dataclass(frozen=True)
class Robot:
    """Actual parameters of a robot, and its rig."""

    kind: Kind
    rig: Rig
    links: Links
    friction: Friction


@dataclass(frozen=True)
class _BaseRobot:
    geometry: Geometry
    links: Links
    friction: Friction
    gain: float


_KINDS = {
    "default": _BaseRobot(
        Geometry(),
        _TABLE_1,
        Friction(),
        gain=1.0,
    ),
    # Gravity dominates: the torque never changes sign.
    "heavy": _BaseRobot(
        Geometry(L1=0.4, L2=0.95, R=0.24, r=0.06, L2_source="measured"),
        _TABLE_1.model_copy(update={"arm_mass": 5.0, "arm_com": 0.18, "payload": 3.0, "motor_inertia": 0.04}),
        Friction(viscous=(0.3, 0.25, 0.35), coulomb=(1.0, 1.2, 0.9)),
        gain=1.6,
    ),
    # Inertia dominates: the arms have counterweights, and the torque changes sign with the acceleration.
    "light": _BaseRobot(
        Geometry(L1=0.26, L2=0.62, R=0.16, r=0.04, L2_source="measured"),
        Links(arm_mass=0.7, arm_com=0.03, arm_inertia=0.03, motor_inertia=0.03, rod_mass=0.07, platform_mass=0.15),
        Friction(viscous=(0.07, 0.06, 0.08), coulomb=(0.15, 0.18, 0.16)),
        gain=0.5,
    ),
}


def draw(kind: Kind, rng: np.random.Generator, *, rate: float, bits: int, reports_command: bool) -> Robot:
    """Random robot of the `kind`.

    rate: sampling rate of its recordings [Hz]; bits: encoder resolution per turn of the joint, rounded to whole
    counts per turn of the motor.
    """
    base = _any_size(rng) if kind == "any" else _KINDS[kind]

    def varied(value: float) -> float:
        return float(value * rng.uniform(1 - _SPREAD, 1 + _SPREAD))

    links = base.links.model_copy(update={name: varied(value) for name, value in base.links.model_dump().items()})
    friction = Friction.model_validate(
        {name: tuple(varied(value) for value in values) for name, values in base.friction.model_dump().items()}
    )
    return Robot(kind, _rig(base, rate, bits, reports_command), links, friction)


def _any_size(rng: np.random.Generator) -> _BaseRobot:
    """A robot whose lengths, masses and friction differ from those of a random kind by independent factors."""
    base = _KINDS[list(_KINDS)[rng.integers(len(_KINDS))]]

    def factor(power: float) -> float:
        return float(_SCALE ** rng.uniform(-power, power))

    scale = factor(1.0)
    geometry = {
        name: getattr(base.geometry, name) * scale * rng.uniform(1 - _PROPORTION, 1 + _PROPORTION)
        for name in ("L1", "L2", "R", "r")
    }
    links = {name: value * factor(2.0) for name, value in base.links.model_dump().items()}
    friction = {
        name: tuple(value * factor(2.0) for value in values) for name, values in base.friction.model_dump().items()
    }
    return _BaseRobot(
        base.geometry.model_copy(update=geometry | {"L2_source": "measured"}),
        base.links.model_copy(update=links),
        Friction.model_validate(friction),
        base.gain * factor(2.0),
    )


def _rig(base: _BaseRobot, rate: float, bits: int, reports_command: bool) -> Rig:
    gear = Drive(node_id=1).gear
    voltage = Voltage(kind="command" if reports_command else "motor")
    counts = round(2**bits / gear)
    drives = tuple(Drive(node_id=i, counts_per_turn=counts, gear=gear, voltage=voltage) for i in (1, 2, 3))
    return Rig(
        name="foreign delta robot",
        rate=rate,
        geometry=base.geometry,
        torque=Torque(gain=(base.gain,) * 3, gain_source="calibrated", gain_uncertainty=0.02),
        drives=drives,
    )


def rig_file(rig: Rig) -> str:
    """The rig as a TOML file."""
    geometry, torque = rig.geometry, rig.torque
    lines = [
        f'name = "{rig.name}"',
        f"rate = {rig.rate}",
        "[geometry]",
        *(f"{name} = {getattr(geometry, name)}" for name in ("L1", "L2", "R", "r")),
        f'L2_source = "{geometry.L2_source}"',
        "[torque]",
        f'map = "{torque.map}"',
        f"gain = {list(torque.gain)}",
        f'gain_source = "{torque.gain_source}"',
        f"gain_uncertainty = {torque.gain_uncertainty}",
    ]
    for drive in rig.drives:
        lines += [
            "[[drives]]",
            f"node_id = {drive.node_id}",
            f"counts_per_turn = {drive.counts_per_turn}",
            f"gear = {drive.gear}",
            f'voltage = {{ kind = "{drive.voltage.kind}" }}',
        ]
    return "\n".join(lines) + "\n"
