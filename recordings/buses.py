"""The section [bus] of the rig description: the connection to the drives, one class per transport."""

import tomllib
from ipaddress import ip_address
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator

from recordings.config import ConfigSection, Positive, validated
from recordings.errors import BadInput

Mask = Annotated[int, Field(ge=0, lt=2**32)]


Register = Annotated[str, Field(min_length=1)]
"""Name of a register that every drive must have."""
_UDP_GROUP, _UDP_PORT, _UDP_PORTS = "239.74.163.2", 43113, 10_000
"""Group and port of python-can's udp_multicast, and how many ports groups are spread over."""


class CanBus(ConfigSection):
    """A CAN bus. `interface`, `channel`, `bitrate` and `options` as in python-can."""

    transport: Literal["canopen"] = "canopen"
    interface: Annotated[str, Field(pattern="^[a-z0-9_-]+$")] = "virtual"
    """Any interface of python-can, e.g. socketcan, pcan, kvaser, ixxat, vector, slcan, gs_usb; virtual: simulated
    drives inside this program; udp_multicast: those of another program."""
    channel: Annotated[str, BeforeValidator(str)] = "delta"
    """Text or number."""
    port: Annotated[int, Field(ge=1024, le=65535)] | None = None
    """UDP port, for udp_multicast only; None: one of this group, 43113 of python-can's group 239.74.163.2."""
    bitrate: Annotated[int, Field(gt=0)] = 1_000_000
    """[bit/s]; passed on to the adapter, except with socketcan (`ip link`)."""
    options: dict[str, str | int | float | bool] = Field(default_factory=dict)
    """Further arguments of this interface of python-can, e.g. { index = 0 } for gs_usb."""
    max_load: Annotated[float, Field(gt=0, le=1)] = 0.8
    """Largest bus load of the cycle in the worst case, as a fraction."""
    sync: Literal["host", "kernel"] = "host"
    """Sender of SYNC in real time: the cycle, or the kernel (broadcast manager), which a busy host does not delay."""

    @property
    def udp_port(self) -> int:
        """Port of udp_multicast: a group without one has its own, since a socket hears all groups of its port.

        Raises:
            BadInput: the channel is no address.
        """
        if self.port is not None:
            return self.port
        try:
            group = int(ip_address(self.channel))
        except ValueError:
            raise BadInput(
                f"bus.channel: address of a multicast group expected, e.g. 239.74.163.2, {self.channel!r} found"
            ) from None
        return _UDP_PORT + (group - int(ip_address(_UDP_GROUP))) % _UDP_PORTS

    @model_validator(mode="after")
    def _check_sync(self) -> Self:
        if self.sync == "kernel" and self.interface != "socketcan":
            raise ValueError(f'sync = "kernel" needs interface = "socketcan", "{self.interface}" found')
        return self


def bus_from(text: str) -> CanBus:
    """The CAN bus of the option --bus: INTERFACE:CHANNEL, or udp_multicast:ADDRESS:PORT; `,KEY=VALUE` may follow, the
    bit rate or options of the interface.

    Raises:
        BadInput: it has another form.
    """
    bus, *pairs = text.split(",")
    interface, _, channel = bus.partition(":")
    if not channel or not all(pair.partition("=")[2] for pair in pairs):
        form = "INTERFACE:CHANNEL[,KEY=VALUE...] expected, e.g. socketcan:can0 or gs_usb:0,index=0,bitrate=500000"
        raise BadInput(f"--bus: {form}; {text!r} found")
    options = {key: _value(value) for key, _, value in (pair.partition("=") for pair in pairs)}
    settings: dict[str, Any] = {"interface": interface, "channel": channel, "options": options}
    settings |= {"bitrate": options.pop("bitrate")} if "bitrate" in options else {}
    if interface == "udp_multicast" and ":" in channel:
        settings["channel"], _, port = channel.rpartition(":")
        settings["port"] = int(port) if port.isdigit() else port
    return validated(settings, CanBus, "--bus")


def _value(text: str) -> Any:
    """A value as in TOML; what is none is a text."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


class SerialRegisters(ConfigSection):
    """Names of the drive's registers, Copley-style: check them against the drive's manual. "": no such register;
    what it would protect is missing then, see `accept_missing`."""

    position_command: Register = "r0xca"
    """Target [counts]."""
    position: Register = "r0x32"
    """Measured [counts]."""
    voltage: Register = "r0x15"
    """Operating voltage of the motor; its scale is in `voltage` of each drive."""
    state: Register = "r0x24"
    """Desired state: `enable` or `disable` of the bus section."""
    status: Register = "r0xa0"
    """Status bits, see SerialStatus."""
    fault: str = "r0xa4"
    """Latched faults, cleared by writing the same bits."""
    following_error: str = "r0xba"
    """Commanded minus measured position at which the drive reports a fault [counts]."""
    deceleration: str = "r0xcf"
    """Deceleration of a quick stop, in units of `deceleration_unit`."""
    upper_limit: str = "r0xb8"
    lower_limit: str = "r0xb9"
    """Position limits that the drive itself enforces: `upper_limit` and `lower_limit` [counts]."""
    device: str = "f0x80"
    """Model, as text or number."""
    torque_offset: str = ""
    """Torque added to the demand of the drive's loops [thousandths of the motor's rated torque]."""
    watchdog: str = ""
    """Timeout after which the drive stops if the host is silent [ms]; 0: no timeout. Few drives have it; one
    without it is driven only with `accept_missing = ["watchdog"]`."""


class SerialStatus(ConfigSection):
    """Bit masks of the status register, Copley-style: check them against the drive's manual."""

    fault: Mask = 0x0040_0000
    off: Mask = 0x0000_8000
    """No torque (PWM outputs disabled)."""
    moving: Mask = 0x0800_2000
    """A motion or a stop is in progress."""


class SerialBus(ConfigSection):
    """Drives that speak the ASCII protocol (`s` set, `g` get; `ok`, `v value`, `e code`) on serial lines."""

    transport: Literal["serial"] = "serial"
    ports: Annotated[tuple[str, ...], Field(min_length=1)] = ("simulated",)
    """One line shared by all drives, or one per drive; names that begin with "simulated" are simulated lines."""
    baud: Annotated[int, Field(ge=1200)] = 115_200
    prefixes: tuple[str, ...] = ()
    """Address prefix of each drive, e.g. "2 " or ".b "; default: the node id on a shared line, otherwise none."""
    echo: bool = False
    """True where the line echoes every command before the reply (two-wire RS-485)."""
    turnaround: Annotated[float, Field(ge=0)] = 0.0003
    """Delay from the end of a command to the start of its reply, adapter and host included [s]."""
    reply_timeout: Positive = 0.01
    """Time after which a missing reply is given up [s]."""
    max_load: Annotated[float, Field(gt=0, le=0.8)] = 0.75
    """Largest fraction of the period that the commands and replies of one cycle may take in the worst case."""
    registers: SerialRegisters = SerialRegisters()
    status: SerialStatus = SerialStatus()
    enable: int = 21
    """Value of the desired state with the position loop closed."""
    disable: int = 0
    """Value of the desired state without power."""
    update: str = "t 1"
    """Command that activates a new target; "" where writing the target is enough."""
    quick_stop: str = "t 0"
    """Command that brings the drive to rest on its own ramp, still powered."""
    deceleration_unit: Positive = 10.0
    """[counts/s^2]."""
    watchdog_timeout: Annotated[float, Field(ge=0.001)] = 0.25
    """[s], written in ms, of which 0 would be no timeout."""
    setup: dict[str, int] = Field(default_factory=lambda: {"r0xc8": 0})
    """Further registers written and read back before power-on, e.g. profile type, speed, acceleration."""

    @property
    def character(self) -> float:
        """Transmission time of one character: start bit, eight data bits, stop bit [s]."""
        return 10 / self.baud

    @model_validator(mode="after")
    def _check_addresses(self) -> Self:
        if len(set(self.ports)) != len(self.ports):
            raise ValueError(f"every port once expected in ports, {list(self.ports)} found")
        if len(self.ports) == 1 and len(set(self.prefixes)) != len(self.prefixes):
            raise ValueError(f"drives on one line need prefixes of their own, {list(self.prefixes)} found")
        return self


def _transport(bus: Any) -> str:
    # Angle brackets mark the tag, so that `recordings.config` does not report it as a key of the file.
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
