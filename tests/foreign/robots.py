"""Delta robots of three sizes, each a little different from seed to seed, and their rig files."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from drivers.simulated.config import Friction, Links
from recordings.rig import Drive, Geometry, Rig, Torque, Voltage

Kind = Literal["default", "heavy", "light"]
_SPREAD = 0.1
"""Half of the range in which masses, inertias and friction lie around the kind's, relative."""
_TABLE_1 = Links()


@dataclass(frozen=True)
class Robot:
    """What a robot really is, and what its rig file says."""

    kind: Kind
    rig: Rig
    links: Links
    friction: Friction


@dataclass(frozen=True)
class _Kind:
    geometry: Geometry
    links: Links
    friction: Friction
    gain: float


_KINDS: dict[Kind, _Kind] = {
    "default": _Kind(
        Geometry(),
        _TABLE_1,
        Friction(),
        gain=1.0,
    ),
    # Weight rules: the torque never changes its sign.
    "heavy": _Kind(
        Geometry(L1=0.4, L2=0.95, R=0.24, r=0.06, L2_source="measured"),
        _TABLE_1.model_copy(update={"arm_mass": 5.0, "arm_com": 0.18, "payload": 3.0, "motor_inertia": 0.04}),
        Friction(viscous=(0.3, 0.25, 0.35), coulomb=(1.0, 1.2, 0.9)),
        gain=1.6,
    ),
    # Inertia rules: the arms have counterweights, and the torque changes its sign with every acceleration.
    "light": _Kind(
        Geometry(L1=0.26, L2=0.62, R=0.16, r=0.04, L2_source="measured"),
        Links(arm_mass=0.7, arm_com=0.03, arm_inertia=0.03, motor_inertia=0.03, rod_mass=0.07, platform_mass=0.15),
        Friction(viscous=(0.07, 0.06, 0.08), coulomb=(0.15, 0.18, 0.16)),
        gain=0.5,
    ),
}


def draw(kind: Kind, rng: np.random.Generator, *, rate: float, bits: int, reports_command: bool) -> Robot:
    """A robot of the `kind`.

    rate: of its recordings [Hz]; bits: of its encoders, per turn of the joint (a count of the motor's divides it by
    the gear, so that it is met within half a count).
    """
    of = _KINDS[kind]

    def near(value: float) -> float:
        return float(value * rng.uniform(1 - _SPREAD, 1 + _SPREAD))

    links = of.links.model_copy(update={name: near(value) for name, value in of.links.model_dump().items()})
    friction = Friction.model_validate(
        {name: tuple(near(value) for value in values) for name, values in of.friction.model_dump().items()}
    )
    return Robot(kind, _rig(of, rate, bits, reports_command), links, friction)


def _rig(of: _Kind, rate: float, bits: int, reports_command: bool) -> Rig:
    gear = Drive(node_id=1).gear
    voltage = Voltage(kind="command" if reports_command else "motor")
    counts = round(2**bits / gear)
    drives = tuple(Drive(node_id=i, counts_per_turn=counts, gear=gear, voltage=voltage) for i in (1, 2, 3))
    return Rig(
        name="foreign delta robot",
        rate=rate,
        geometry=of.geometry,
        torque=Torque(gain=(of.gain,) * 3, gain_source="calibrated", gain_uncertainty=0.02),
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
