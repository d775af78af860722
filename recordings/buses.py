"""How the drives are reached: the section [bus] of the rig description, one class per transport."""

from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from recordings.config import ConfigSection

Positive = Annotated[float, Field(gt=0)]
Mask = Annotated[int, Field(ge=0, lt=2**32)]


class CanBus(ConfigSection):
    """A CAN bus. `interface` and `channel` as in python-can."""

    transport: Literal["canopen"] = "canopen"
    interface: Literal["virtual", "udp_multicast", "socketcan"] = "virtual"
    channel: str = "delta"
    port: Annotated[int, Field(ge=1024, le=65535)] = 43113
    """UDP port, for udp_multicast only."""
    bitrate: Annotated[int, Field(gt=0)] = 1_000_000
    max_load: Annotated[float, Field(gt=0, le=1)] = 0.8
    """The share of the bus that the cycle may take at worst."""
    sync: Literal["host", "kernel"] = "host"
    """Who sends SYNC in real time: the cycle itself, or the kernel (broadcast manager), however busy the host is."""

    @model_validator(mode="after")
    def _kernel_has_it(self) -> Self:
        if self.sync == "kernel" and self.interface != "socketcan":
            raise ValueError(f'sync = "kernel" needs interface = "socketcan", "{self.interface}" found')
        return self


class SerialRegisters(ConfigSection):
    """Names of the drive's registers, Copley-style: to be checked against the drive's manual. "": it has none."""

    position_command: str = "r0xca"
    """Target [counts]."""
    position: str = "r0x32"
    """Measured [counts]."""
    voltage: str = "r0x15"
    """The motor's operating voltage; its scale stands in each drive's `voltage`."""
    state: str = "r0x24"
    """Desired state: `enable` or `disable` of the bus section."""
    status: str = "r0xa0"
    """Bits, see SerialStatus."""
    fault: str = "r0xa4"
    """Latched faults, cleared by writing the same bits."""
    following_error: str = "r0xba"
    """Commanded minus measured position at which the drive gives up [counts]."""
    deceleration: str = "r0xcf"
    """Of a quick stop, in units of `deceleration_unit`."""
    upper_limit: str = "r0xb8"
    lower_limit: str = "r0xb9"
    """Where the drive itself ends the motion [counts]."""
    device: str = "f0x80"
    """Model, as text or number."""
    watchdog: str = ""
    """Silence of the host after which the drive stops by itself [ms]; 0: for ever. Few drives have it."""


class SerialStatus(ConfigSection):
    """What the bits of the status register mean, Copley-style: to be checked against the drive's manual."""

    fault: Mask = 0x0040_0000
    off: Mask = 0x0000_8000
    """No torque (PWM outputs disabled)."""
    moving: Mask = 0x0800_2000
    """A motion, or a stop, is not at its end."""


class SerialBus(ConfigSection):
    """Drives that speak the ASCII protocol (`s` set, `g` get; `ok`, `v value`, `e code`) on serial lines."""

    transport: Literal["serial"] = "serial"
    ports: Annotated[tuple[str, ...], Field(min_length=1)] = ("simulated",)
    """One line that all drives share, or one for each; names that begin with "simulated" are simulated here."""
    baud: Annotated[int, Field(ge=1200)] = 115_200
    prefixes: tuple[str, ...] = ()
    """What addresses each drive, e.g. "2 " or ".b "; if left out its node id on a shared line, else nothing."""
    echo: bool = False
    """Whether everything sent comes back before the reply (two-wire RS-485)."""
    turnaround: Annotated[float, Field(ge=0)] = 0.0003
    """From the end of a command to the start of its reply, adapter and host included [s]."""
    reply_timeout: Positive = 0.01
    """A drive that has not replied by then will not reply any more [s]."""
    max_load: Annotated[float, Field(gt=0, le=0.8)] = 0.75
    """The share of the period that the commands and replies of one cycle may take at worst."""
    registers: SerialRegisters = SerialRegisters()
    status: SerialStatus = SerialStatus()
    enable: int = 21
    """Desired state with the position loop closed."""
    disable: int = 0
    """Desired state without power."""
    update: str = "t 1"
    """Command that makes a new target count; "" where writing it is enough."""
    quick_stop: str = "t 0"
    """Command that brings the drive to rest on its own ramp, still powered."""
    deceleration_unit: Positive = 10.0
    """[counts/s^2]."""
    watchdog_timeout: Positive = 0.25
    """[s]."""
    setup: dict[str, int] = Field(default_factory=lambda: {"r0xc8": 0})
    """More registers to be written and read back before power, e.g. profile type, speed, acceleration."""

    @property
    def character(self) -> float:
        """Time that one character takes on the wire: start bit, eight data bits, stop bit [s]."""
        return 10 / self.baud

    @model_validator(mode="after")
    def _addressed(self) -> Self:
        if len(set(self.ports)) != len(self.ports):
            raise ValueError(f"every port once expected in ports, {list(self.ports)} found")
        if len(self.ports) == 1 and len(set(self.prefixes)) != len(self.prefixes):
            raise ValueError(f"drives on one line need prefixes of their own, {list(self.prefixes)} found")
        return self


def _transport(bus: Any) -> str:
    # The brackets tell `recordings.config` that this is no key of the file.
    transport = bus.get("transport", "canopen") if isinstance(bus, dict) else getattr(bus, "transport", None)
    return f"<{transport}>"


Bus = Annotated[
    Annotated[CanBus, Tag("<canopen>")] | Annotated[SerialBus, Tag("<serial>")],
    Discriminator(
        _transport,
        custom_error_type="transport",
        custom_error_message='a section with transport = "canopen" (or none) or "serial" expected',
    ),
]
