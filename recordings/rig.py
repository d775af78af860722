"""The rig description: the machine, the connection of its drives and its limits.

It is read from a TOML file, stored in every recording and shared by all packages. All values are in SI units and
radians; counts appear only as scale factors of the drives.
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationInfo, field_validator, model_validator

from recordings.buses import Bus, CanBus, SerialBus
from recordings.config import ConfigSection, Positive, toml_content, validated
from recordings.drives import PROTECTIONS
from recordings.drives import AssumedUnits as AssumedUnits
from recordings.drives import Drive as Drive
from recordings.drives import HomedBit as HomedBit
from recordings.drives import Homing as Homing
from recordings.drives import Voltage as Voltage
from recordings.errors import BadInput
from recordings.urdf import Chain, with_text
from recordings.urdf_joints import JointType as JointType

MechanismName = Literal["delta", "axes", "urdf"]


class Geometry(ConfigSection):
    """Lengths of the delta robot [m] and directions of its limbs [rad]: Table 1, Fig. 2.

    L2 is not given in the paper; the default of 0.8 m is assumed.
    """

    L1: Positive = 0.3423
    L2: Positive = 0.8
    R: Positive = 0.2
    r: Positive = 0.045
    phi: tuple[float, float, float] = (math.pi / 3, math.pi, 5 * math.pi / 3)
    L2_source: Literal["assumed", "measured"] = "assumed"

    @model_validator(mode="after")
    def _check_closure(self) -> Self:
        if self.L2 <= self.L1 + abs(self.R - self.r):
            raise ValueError(
                f"the forearms are too short to close the mechanism: L2 > L1 + |R - r| = "
                f"{self.L1 + abs(self.R - self.r):g} m expected, L2 = {self.L2:g} m found"
            )
        return self


class Nominal(ConfigSection):
    """The manufacturer's masses and inertias, Table 1: the reference model and the torque estimate before a run."""

    m_a: Positive = 3.977
    m_d: Positive = 0.402
    m_p: Positive = 2.033
    L1c: Positive = 0.1563
    I_L1: Positive = 191.9e-4
    motor_inertia: Positive = 21**2 * 2.25e-4
    """Motor inertia seen at the joint, gear ratio squared included [kg m^2]."""


class Torque(ConfigSection):
    """Map from voltage v to torque: gain * v * |v| ("square") or gain * v ("linear")."""

    map: Literal["square", "linear"] = "square"
    gain: tuple[Positive, ...] = (1.0, 1.0, 1.0)
    """Gain per joint [N m / V^2 or N m / V; N instead of N m for a prismatic joint]; default 1.0."""
    per_ampere: tuple[Positive, ...] = ()
    """Torque per motor current, per joint [N m/A, or N/A], for imported currents; none where it is not known."""
    gain_source: Literal["calibrated", "assumed"] = "assumed"
    gain_uncertainty: Annotated[float, Field(ge=0, lt=1)] = 0.1
    """Relative standard uncertainty of the gain."""


class Axis(ConfigSection):
    """One joint of the mechanism "axes": n joints that move independently of each other."""

    type: JointType = "revolute"
    gravity: bool = False
    """True where gravity loads the joint; on a revolute joint this torque depends on the angle."""


class Limits(ConfigSection):
    """Limits of the machine, checked before a motion starts and monitored while it runs."""

    joint_min: float = -1.2
    joint_max: float = 1.4
    """Joint angle [rad]."""
    speed: Positive = 12.0
    """Joint speed [rad/s]."""
    acceleration: Positive = 150.0
    """Joint acceleration [rad/s^2]."""
    torque: Positive = 60.0
    """Joint torque [N m]."""
    workspace_radius: Positive = 0.45
    """Platform distance from the z axis [m]."""
    workspace_z: tuple[float, float] = (-1.05, -0.45)
    """Platform height [m]."""
    following_error: Positive = 0.05
    """Commanded minus measured joint angle [rad]."""
    torque_offset: Annotated[float, Field(gt=0, le=3)] = 1.0
    """Largest torque offset of a feed-forward, as a share of each drive's rated_torque; larger ones are cut off."""
    silence: Positive = 0.05
    """Longest time without an answer from a drive [s]."""
    host_stall: Positive = 0.05
    """Largest delay of the host [s]."""
    singularity_margin: Positive = 0.05
    """Smallest allowed singularity margin (see trajectories.kinematics), dimensionless."""

    def joint_counts(self, drive: Drive) -> tuple[int, int]:
        """Lowest and highest encoder position of a drive within the joint limits [counts]."""
        low, high = sorted(round(drive.to_counts(angle)) for angle in (self.joint_min, self.joint_max))
        return low, high

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        if self.joint_min >= self.joint_max:
            raise ValueError(f"joint_min < joint_max expected, {self.joint_min:g} and {self.joint_max:g} found")
        if self.workspace_z[0] >= self.workspace_z[1]:
            raise ValueError(f"workspace_z = [lowest, highest] expected, {list(self.workspace_z)} found")
        return self


class Rig(Chain):
    """The whole rig. `geometry`, `nominal` and the platform limits apply to a delta robot only."""

    name: str
    mechanism: MechanismName = "delta"
    rate: Annotated[float, Field(gt=0, le=4000)] = 500.0
    """Cycles (SYNC) per second [Hz]."""
    enable_timeout: Positive = 3.0
    """Longest time that the drives may take to enable [s]."""
    axes: tuple[Axis, ...] = ()
    """Joints of the mechanism "axes", in the order of the drives; empty for a delta robot."""
    geometry: Geometry = Geometry()
    nominal: Nominal = Nominal()
    torque: Torque = Field(default=Torque(), validate_default=True)
    bus: Bus = CanBus()
    limits: Limits = Limits()
    drives: tuple[Drive, ...] = ()
    """One drive per joint; none where the rig is not driven (an imported recording)."""

    @field_validator("torque")
    @classmethod
    def _default_gains(cls, torque: Torque, info: ValidationInfo) -> Torque:
        if "gain" in torque.model_fields_set or info.data.get("mechanism") == "delta":
            return torque
        return torque.model_copy(update={"gain": (1.0,) * len(info.data.get("axes") or info.data.get("joints", ()))})

    @model_validator(mode="after")
    def _check_consistency(self) -> Self:
        self._check_keys_of_mechanism()
        if len(self.drives) not in (0, self.dof):
            robot = (
                "a delta robot has three"
                if self.mechanism == "delta"
                else f"a rig with {self.dof} joints has as many"
            )
            raise ValueError(f"{robot} [[drives]], {len(self.drives)} found")
        places = [drive.address for drive in self.drives]
        for place in places:
            if places.count(place) > 1:
                raise ValueError(f"every drive needs its own node_id or axis, {place} stands in two [[drives]]")
        if len(self.torque.gain) != self.dof:
            raise ValueError(f"torque.gain needs {self.dof} numbers, {len(self.torque.gain)} found")
        if len(self.torque.per_ampere) not in (0, self.dof):
            raise ValueError(f"torque.per_ampere: none or {self.dof} expected, {len(self.torque.per_ampere)} found")
        self._check_torque_sources()
        is_serial = isinstance(self.bus, SerialBus)
        other = {name for drive in self.drives for name in drive.accept_missing if (name in PROTECTIONS) != is_serial}
        if other:
            expected = ", ".join(PROTECTIONS) if is_serial else "indices of objects"
            raise ValueError(f"accept_missing: {expected} expected on this bus, {', '.join(sorted(other))} found")
        if isinstance(self.bus, SerialBus):
            self._check_lines(self.bus)
        return self

    def _check_torque_sources(self) -> None:
        if len(sources := {drive.torque_source for drive in self.drives}) > 1:
            raise ValueError(f"one torque_source for all drives expected, {', '.join(sorted(sources))} found")
        if sources != {"current_actual"}:
            return
        for joint, drive in enumerate(self.drives, start=1):
            if drive.rated_current is None:
                raise ValueError(
                    f'joint {joint}: torque_source = "current_actual" needs rated_current [A], none found'
                )
        if not self.torque.per_ampere:
            raise ValueError('torque_source = "current_actual" needs torque.per_ampere [N m/A], none found')

    def _check_lines(self, bus: SerialBus) -> None:
        if len(bus.ports) not in (1, self.dof):
            raise ValueError(f"bus.ports: one line for all drives or {self.dof} expected, {len(bus.ports)} found")
        if len(bus.prefixes) not in (0, self.dof):
            raise ValueError(f"bus.prefixes: none or {self.dof} expected, {len(bus.prefixes)} found")
        if any(drive.watched for drive in self.drives):
            raise ValueError("watched: objects of drives on a CAN bus expected, a serial line found; remove it")

    def _check_keys_of_mechanism(self) -> None:
        if self.mechanism == "axes" and not self.axes:
            raise ValueError('the mechanism "axes" needs an [[axes]] section for each joint, none found')
        if self.mechanism == "urdf" and not self.urdf:
            raise ValueError('the mechanism "urdf" needs the key urdf, none found; give the path of the file')
        for mechanism, keys in _KEYS_OF_MECHANISM.items():
            for key in keys if mechanism != self.mechanism else ():
                if getattr(self, key) != Rig.model_fields[key].get_default(call_default_factory=True):
                    raise ValueError(
                        f'{key} belongs to the mechanism "{mechanism}", "{self.mechanism}" found; remove it or set '
                        "the mechanism"
                    )

    @property
    def can(self) -> CanBus:
        """The bus of a rig whose transport is CANopen.

        Raises:
            BadInput: the transport is another one.
        """
        if not isinstance(self.bus, CanBus):
            raise BadInput(f"a rig on a CAN bus expected, bus.transport = '{self.bus.transport}' found")
        return self.bus

    @property
    def serial(self) -> SerialBus:
        """The lines of a rig whose transport is serial.

        Raises:
            BadInput: the transport is another one.
        """
        if not isinstance(self.bus, SerialBus):
            raise BadInput(f"a rig on serial lines expected, bus.transport = '{self.bus.transport}' found")
        return self.bus

    @property
    def dof(self) -> int:
        """Number of joints."""
        return len(self.joint_types)

    @property
    def joint_types(self) -> tuple[JointType, ...]:
        """Type of each joint."""
        if self.mechanism == "urdf":
            return self.types
        return tuple(axis.type for axis in self.axes) if self.mechanism == "axes" else ("revolute",) * 3

    @property
    def position_units(self) -> tuple[str, ...]:
        """Position unit of each joint: rad or m."""
        return tuple("rad" if joint == "revolute" else "m" for joint in self.joint_types)

    @property
    def effort_units(self) -> tuple[str, ...]:
        """Effort unit of each joint: N m or N."""
        return tuple("N m" if joint == "revolute" else "N" for joint in self.joint_types)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joint names in recordings: joint_1 ... joint_n."""
        return tuple(f"joint_{i + 1}" for i in range(self.dof))

    def target_counts(self, targets: NDArray[np.float64]) -> NDArray[np.int64]:
        """Encoder counts (n, dof) of joint targets (n, dof) [rad].

        Raises:
            BadInput: a target is unknown or exceeds 32 bits.
        """
        columns = [drive.to_counts(target) for drive, target in zip(self.drives, targets.T, strict=True)]
        counts: NDArray[np.float64] = np.rint(np.column_stack(columns))
        if not np.all(np.abs(counts) < 2**31):
            raise BadInput("a target lies outside the encoder's 32 bits; check counts_per_turn, gear and zero_offset")
        return counts.astype(np.int64)

    def torque_offset_counts(
        self, torque: NDArray[np.float64], rated: Sequence[float] | None = None
    ) -> NDArray[np.int64]:
        """Torque offsets (n, dof) [thousandths of the rated torque, in the drive's direction] of torques [N m].

        1000 sign torque / (gear 6076h 10^-3), cut off at limits.torque_offset. `rated`: gear 6076h 10^-3 of each
        drive [N m]; default: rated_torque.
        """
        rated = [drive.rated_torque for drive in self.drives] if rated is None else rated
        share = torque * [drive.sign / limit for drive, limit in zip(self.drives, rated, strict=True)]
        limit = self.limits.torque_offset
        return np.rint(1000 * np.clip(share, -limit, limit)).astype(np.int64)

    def with_torque_offset(self) -> "Rig":
        """Copy the rig with a torque offset sent to every drive.

        Raises:
            BadInput: a drive has a mode without it.
        """
        drives = [drive.model_dump(mode="json") | {"torque_offset": True} for drive in self.drives]
        return validated(self.model_dump(mode="json") | {"drives": drives}, Rig, "--feedforward")

    def at_rate(self, rate: float) -> "Rig":
        """Copy the rig with another cycle rate [Hz].

        Raises:
            BadInput: the rate is invalid.
        """
        return validated(self.model_dump(mode="json") | {"rate": rate}, Rig, "--rate")


_KEYS_OF_MECHANISM = {
    "delta": ("geometry", "nominal"),
    "axes": ("axes",),
    "urdf": tuple(name for name in Chain.model_fields if name != "payload"),
}
"""Keys that describe one mechanism alone."""


def simulated_rig() -> Rig:
    """The default rig where no rig file is given: the robot of Table 1 with three simulated drives."""
    return Rig(name="simulated delta robot", drives=tuple(Drive(node_id=i) for i in (1, 2, 3)))


def is_default(rig: Rig) -> bool:
    """Whether `rig` is the default rig, at any rate."""
    default = simulated_rig()
    return rig.model_copy(update={"rate": default.rate}) == default


def load_rig(path: Path, *, driven: bool = True) -> Rig:
    """Read a rig file; `driven` requires drives.

    Raises:
        BadInput: the file is missing, is not TOML, a key is unknown, missing or of the wrong type, or no drives.
    """
    rig = validated(with_text(toml_content(path, "rig file"), path.parent), Rig, f"rig file {path}")
    if driven and not rig.drives:
        raise BadInput(f"rig file {path}: one of [[drives]] for each of {rig.dof} joints expected, none found")
    return rig
