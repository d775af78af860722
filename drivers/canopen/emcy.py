"""Emergency messages (EMCY, CiA 301): texts, and which of them end a run."""

import struct
from dataclasses import dataclass

_LAYOUT = struct.Struct("<HB5s")

_TEXTS: dict[int, str] = {
    0x1000: "generic error",
    0x2110: "short circuit or earth leakage at the input",
    0x2120: "earth leakage at the input",
    0x2130: "short circuit at the input",
    0x2211: "over-current inside the drive",
    0x2220: "continuous over-current inside the drive",
    0x2230: "short circuit or earth leakage inside the drive",
    0x2250: "short circuit inside the drive",
    0x2310: "continuous over-current",
    0x2320: "short circuit or earth leakage at the motor",
    0x2330: "earth leakage at the motor",
    0x2340: "short circuit at the motor",
    0x2350: "motor overload (I2t)",
    0x2351: "motor overload warning (I2t)",
    0x3110: "mains over-voltage",
    0x3120: "mains under-voltage",
    0x3130: "mains phase failure",
    0x3210: "DC link over-voltage",
    0x3220: "DC link under-voltage",
    0x3310: "output over-voltage",
    0x4110: "ambient over-temperature",
    0x4210: "device over-temperature",
    0x4310: "drive over-temperature",
    0x4410: "supply over-temperature",
    0x5112: "24 V supply too low",
    0x5200: "control hardware",
    0x5400: "power section",
    0x5410: "output stages",
    0x5440: "contacts",
    0x5450: "fuses",
    0x5530: "non-volatile memory",
    0x6010: "software reset (watchdog)",
    0x6100: "internal software",
    0x6200: "user software",
    0x6310: "parameters lost",
    0x6320: "parameter error",
    0x7110: "brake chopper",
    0x7120: "motor",
    0x7121: "motor blocked",
    0x7122: "motor or commutation",
    0x7300: "sensor",
    0x7303: "resolver",
    0x7305: "encoder error",
    0x7306: "second encoder",
    0x7310: "speed sensor",
    0x7320: "position sensor",
    0x7500: "communication inside the drive",
    0x8110: "CAN overrun: frames lost",
    0x8120: "CAN controller error-passive",
    0x8130: "master heartbeat lost",
    0x8140: "recovered from bus-off",
    0x8150: "two nodes use one CAN id",
    0x8210: "PDO too short",
    0x8220: "PDO too long",
    0x8240: "SYNC of unexpected length",
    0x8250: "setpoints (RPDO) lost",
    0x8311: "excess torque",
    0x8331: "torque fault",
    0x8400: "speed controller",
    0x8500: "position controller",
    0x8611: "following error",
    0x8612: "position limit",
    0x8700: "synchronisation with SYNC",
    0x9000: "external error",
    0xF001: "deceleration",
}

_CLASSES: dict[int, str] = {
    **{0x10: "generic error", 0x20: "current", 0x21: "current at the input", 0x22: "current inside the drive"},
    **{0x23: "current at the output", 0x30: "voltage", 0x31: "mains voltage", 0x32: "voltage inside the drive"},
    **{0x33: "output voltage", 0x40: "temperature", 0x41: "ambient temperature", 0x42: "device temperature"},
    **{0x43: "drive temperature", 0x50: "hardware", 0x60: "software", 0x61: "internal software"},
    **{0x62: "user software", 0x63: "data set", 0x70: "additional module", 0x80: "monitoring"},
    **{0x81: "communication", 0x82: "protocol", 0x83: "torque control", 0x84: "speed control"},
    **{0x85: "position control", 0x86: "positioning", 0x90: "external error", 0xF0: "additional function"},
    0xFF: "the manufacturer's own code",
}

_STOPPING = range(0x2, 0xA)
"""First digits of the codes that end a run whatever the error register says: current, voltage, temperature, hardware,
software, modules, monitoring, external."""
_WARNINGS = {0x2351, 0x8140}
"""Codes of those classes that are warnings by the standard."""


@dataclass(frozen=True)
class Emergency:
    """One EMCY message."""

    code: int
    """0: error reset."""
    register: int
    """Error register (object 1001)."""
    manufacturer: bytes
    """The five bytes of the manufacturer."""

    @property
    def text(self) -> str:
        """The code in words."""
        return describe(self.code)

    @property
    def ends_run(self) -> bool:
        """Whether this is an error; otherwise it is a warning, or the reset of an error."""
        if self.code == 0:
            return False
        return self.register != 0 or (self.code >> 12 in _STOPPING and self.code not in _WARNINGS)

    @property
    def details(self) -> str:
        """The manufacturer's bytes, as shown after the text; "" where all are 0."""
        return f" (manufacturer's bytes {self.manufacturer.hex(' ')})" if any(self.manufacturer) else ""


def decode(data: bytes) -> Emergency:
    """Decode an EMCY frame; a short frame is padded with zeros."""
    return Emergency(*_LAYOUT.unpack(data[:8].ljust(8, b"\0")))


def describe(code: int) -> str:
    """Words of CiA 301 and CiA 402 for an error code; codes without their own fall back to their class."""
    if code == 0:
        return "error reset or no error"
    return _TEXTS.get(code) or _CLASSES.get(code >> 8) or _CLASSES.get(code >> 8 & 0xF0) or "unknown error"
