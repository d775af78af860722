"""The sim file: true properties of the simulated machine, which the rig file does not contain."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, model_validator

from drivers.simulated.habits import Habits, NotNegative, Trouble
from recordings.config import ConfigSection, Positive, read_toml

ROBOTS = Path(__file__).with_name("robots")
"""Folder with sim files of further robots."""
Joint = Annotated[int, Field(ge=1, le=3)]
_JOINTS = 3
PerJoint = tuple[NotNegative, NotNegative, NotNegative]


class Links(ConfigSection):
    """Masses [kg] and inertias [kg m^2] of the robot: Table 1 in a physically consistent reading.

    Table 1's I_L1 is smaller than m_a L1c^2, so it can only be about the arm's centre of mass. The inertia at the
    shoulder is then I_L1 + m_a L1c^2 + the motor's inertia = 0.2156 kg m^2.
    """

    arm_mass: Positive = 3.977
    arm_com: Positive = 0.1563
    """Distance of the arm's centre of mass from the shoulder [m]."""
    arm_inertia: Positive = 191.9e-4
    """About the arm's centre of mass."""
    motor_inertia: Annotated[float, Field(ge=0.02)] = 21**2 * 2.25e-4
    """Rotor and gear, reflected to the joint."""
    rod_mass: Positive = 0.402
    """Of the two rods of one limb together, distributed evenly over the length."""
    platform_mass: Positive = 2.033
    payload: NotNegative = 0.0


class Friction(ConfigSection):
    """Friction of each joint, on the motor side."""

    viscous: PerJoint = (0.35, 0.32, 0.38)
    """[N m s/rad]."""
    coulomb: PerJoint = (0.9, 1.0, 0.85)
    """Sliding and static friction [N m]."""


class Servo(ConfigSection):
    """Position loop of the drives, cascaded: position P, velocity PI with feed-forward, current loop."""

    position_gain: Positive = 40.0
    """[1/s]."""
    velocity_gain: Positive = 50.0
    """[N m s/rad]."""
    integral_time: Positive = 0.03
    """Of the velocity controller [s]."""
    exact_reference: bool = False
    """Whether the references of position and velocity are those of the present, as in drives that interpolate by
    cubics. Otherwise the velocity is half a SYNC period old, and the position one and a half plant steps ahead."""
    torque_limit: Positive = 60.0
    """The current limit as torque at the joint [N m]."""
    current_lag: Positive = 4e-4
    """Time constant of the current loop [s]."""
    brake_torque: Positive = 45.0
    """Holding torque of the brake [N m]."""


class EffectSpec(ConfigSection):
    """One hidden effect: its name, joints, and either its size or its parameters."""

    name: str
    joints: tuple[Joint, ...] = (1, 2, 3)
    size: Annotated[float, Field(gt=0, lt=1)] | None = None
    """Unexplained residual over torque (see sizing); determines the effect's first parameter."""
    parameters: Mapping[str, float] = Field(default_factory=dict)
    """By the names in the effect's file; the others have their defaults."""


class SimEvent(ConfigSection):
    """Something that happens to the machine or its drives while it runs."""

    at: NotNegative
    """When it begins, in simulated time from power-on [s]; with the next cycle."""
    effect: EffectSpec | None = None
    """The effect that begins and stays: as in [[effects]]."""
    trouble: Trouble | None = None
    """What happens to drives on a CAN bus instead: as in [drives.habits]."""
    joints: tuple[Joint, ...] = (1, 2, 3)
    """Whose drives have the trouble."""

    @model_validator(mode="after")
    def _check_kind(self) -> Self:
        if (self.effect is None) == (self.trouble is None):
            raise ValueError("[[events]]: either effect or trouble expected")
        return self


class SimDrive(ConfigSection):
    """One simulated CANopen drive."""

    eds: str | None = None
    """EDS or DCF file of its object dictionary, relative to the working folder; None: that of this project."""
    habits: Habits = Habits()


class SimConfig(ConfigSection):
    """The simulated machine."""

    links: Links = Links()
    friction: Friction = Friction()
    servo: Servo = Servo()
    torque_gain: tuple[Positive, Positive, Positive] | None = None
    """True torque gains of the motors, in the rig's torque map; None: those of the rig file."""
    voltage_noise: NotNegative = 0.01
    """Standard deviation of the measured voltage [V]."""
    park: tuple[float, float, float] = (0.0, 0.0, -0.75)
    """Platform position at power-on [m]."""
    drives: tuple[SimDrive, ...] = ()
    """Dictionaries and habits of the drives on a CAN bus: one for each joint, or one for all."""
    effects: tuple[EffectSpec, ...] = ()
    events: tuple[SimEvent, ...] = ()

    @model_validator(mode="after")
    def _check_drives(self) -> Self:
        if len(self.drives) not in (0, 1, _JOINTS):
            raise ValueError(f"[[drives]]: one for all joints or {_JOINTS} expected, {len(self.drives)} found")
        return self

    @property
    def all_effects(self) -> tuple[EffectSpec, ...]:
        """The effects from the beginning, then those of the events."""
        return (*self.effects, *(effect for _, effect in self.effects_that_begin))

    @property
    def effects_that_begin(self) -> tuple[tuple[float, EffectSpec], ...]:
        """Effects of the events, with their times [s]."""
        return tuple((event.at, event.effect) for event in self.events if event.effect is not None)

    def troubles(self, joint: int) -> list[tuple[float, Trouble]]:
        """Troubles of the drive of `joint` (1 ... n), with their times [s]."""
        return [(event.at, event.trouble) for event in self.events if event.trouble and joint in event.joints]

    def with_effects(self, effects: Sequence[EffectSpec]) -> Self:
        """The same machine with others in place of `all_effects`."""
        count = len(self.effects)
        begin = iter(effects[count:])
        events = (
            event if event.effect is None else event.model_copy(update={"effect": next(begin)})
            for event in self.events
        )
        return self.model_copy(update={"effects": tuple(effects[:count]), "events": tuple(events)})

    @property
    def drive_of_each_joint(self) -> tuple[SimDrive, ...]:
        """The simulated drive of each joint."""
        drives = self.drives or (SimDrive(),)
        return drives if len(drives) == _JOINTS else drives * _JOINTS


def load_sim(path: Path) -> SimConfig:
    """Read a sim file, or that of the shipped robot with this name, where there is no such file.

    Raises:
        BadInput: the file is missing, is not TOML, or a key is unknown, missing or of the wrong type.
    """
    shipped = ROBOTS / f"{path.name.removesuffix('.toml')}.toml"
    if not path.exists() and path.parent == Path() and shipped.exists():
        path = shipped
    return read_toml(path, SimConfig, "sim file")
