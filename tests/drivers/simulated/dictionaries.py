"""Object dictionaries of drives that do not exist: an EDS writer, drives with the habits of real ones, and a
strategy that makes up others."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from hypothesis import strategies as st

I8, I16, I32, U8, U16, U32, TEXT = 0x02, 0x03, 0x04, 0x05, 0x06, 0x07, 0x09
INCREMENTS_PER_TURN, GEAR = 8192, 21
RPM, RPM_PER_SECOND = 0x00B4_4700, 0x00C0_0300
RATED_TORQUE, RATED_CURRENT = 952, 4200
"""Of the motor [mN m], [mA]."""

Address = tuple[int, int]


@dataclass(frozen=True)
class Item:
    """One object of an EDS or DCF."""

    data_type: int
    access: str = "rw"
    default: object = 0
    low: int | None = None
    high: int | None = None
    mappable: bool = False
    parameter: object = None
    """Value in a DCF."""
    name: str = "object"


Items = Mapping[Address, Item]


@dataclass(frozen=True)
class MadeUpDrive:
    """A dictionary with the habits of its drive."""

    items: Items
    habits: Mapping[str, Any] = field(default_factory=dict)

    @property
    def eds(self) -> str:
        """Text of the EDS."""
        return eds(self.items)

    def write(self, folder: Path, name: str = "drive") -> tuple[Path, Path]:
        """Write the EDS, and a sim file of three such drives with their habits; returns both paths."""
        path, sim = folder / f"{name}.eds", folder / f"{name}.sim.toml"
        path.write_text(self.eds)
        lines = ["[[drives]]", f"eds = {str(path)!r}", "[drives.habits]"]
        lines += [f"{key} = {_toml(value)}" for key, value in self.habits.items()]
        sim.write_text("\n".join(lines) + "\n")
        return path, sim


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f'"{key}" = {_toml(item)}' for key, item in value.items()) + " }"
    return json.dumps(value)


def eds(items: Items, name: str = "made-up drive") -> str:
    """Text of an EDS with these objects; records get their sub-index 0."""
    lines = ["[FileInfo]", "EDSVersion=4.0", "[DeviceInfo]", f"ProductName={name}", "Granularity=8"]
    for index in sorted({index for index, _ in items}):
        subs = sorted(sub for i, sub in items if i == index)
        if subs == [0]:
            lines += _section(f"{index:04X}", items[index, 0])
            continue
        lines += [f"[{index:04X}]", f"ParameterName=object {index:04X}", "ObjectType=0x9", f"SubNumber={len(subs)}"]
        if subs[0] != 0:
            lines += _section(f"{index:04X}sub0", Item(U8, "ro", subs[-1]))
        for sub in subs:
            lines += _section(f"{index:04X}sub{sub:X}", items[index, sub])
    return "\n".join(lines) + "\n"


def _section(name: str, item: Item) -> Iterator[str]:
    yield f"[{name}]"
    yield f"ParameterName={item.name} {name}"
    yield "ObjectType=0x7"
    yield f"DataType=0x{item.data_type:04X}"
    yield f"AccessType={item.access}"
    for key, value in {
        "DefaultValue": item.default,
        "LowLimit": item.low,
        "HighLimit": item.high,
        "ParameterValue": item.parameter,
    }.items():
        if value is not None:
            yield f"{key}={value}"
    yield f"PDOMapping={int(item.mappable)}"


def pdo(number: int, receive: bool, mapped: list[int], kind: int = 255, valid: bool = True) -> dict[Address, Item]:
    """Objects of one PDO, in the predefined connection set."""
    first = (0x1400 if receive else 0x1800) + number
    base = (0x200 if receive else 0x180) + 0x100 * number + (0 if valid else 0x8000_0000)
    entries = mapped + [0] * (8 - len(mapped))
    return {
        (first, 1): Item(U32, default=f"$NODEID+0x{base:X}"),
        (first, 2): Item(U8, default=kind),
        **({} if receive else {(first, 3): Item(U16), (first, 5): Item(U16)}),
        (first + 0x200, 0): Item(U8, default=len(mapped), low=0, high=8),
        **{(first + 0x200, sub): Item(U32, default=entry) for sub, entry in enumerate(entries, start=1)},
    }


def four_tpdos(kind: int = 255) -> dict[Address, Item]:
    """All four TPDOs, sent from power-up on."""
    mapped = [[0x6041_00_10], [0x6041_00_10, 0x6061_00_08], [0x6041_00_10, 0x6064_00_20], [0x6064_00_20]]
    return {address: item for number, m in enumerate(mapped) for address, item in pdo(number, False, m, kind).items()}


def base(modes: int = 0xC0) -> dict[Address, Item]:
    """A complete drive in increments without voltage, current and torque; `modes`: object 6502h."""
    target, actual = {"access": "rww", "mappable": True, "default": 0}, {"access": "ro", "mappable": True}
    return {
        (0x1000, 0): Item(U32, "ro", 0x20192),
        (0x1001, 0): Item(U8, "ro", mappable=True),
        (0x1005, 0): Item(U32, default=0x80),
        (0x1006, 0): Item(U32),
        (0x1008, 0): Item(TEXT, "const", "made-up drive"),
        (0x1014, 0): Item(U32, default="$NODEID+0x80"),
        (0x1016, 1): Item(U32),
        (0x1017, 0): Item(U16),
        **{(0x1018, sub): Item(U32, "ro", value) for sub, value in ((1, 0x7FF), (2, 2), (3, 3))},
        **pdo(0, True, [0x6040_00_10]),
        **pdo(1, True, [0x6040_00_10, 0x6060_00_08]),
        **pdo(0, False, [0x6041_00_10]),
        **pdo(1, False, [0x6041_00_10, 0x6061_00_08], valid=False),
        (0x6007, 0): Item(I16, default=1, low=0, high=3),
        (0x603F, 0): Item(U16, **actual),
        (0x6040, 0): Item(U16, **target),
        (0x6041, 0): Item(U16, **actual),
        (0x605A, 0): Item(I16, default=2),
        (0x605D, 0): Item(I16, default=1),
        (0x605E, 0): Item(I16, default=2),
        (0x6060, 0): Item(I8, **target),
        (0x6061, 0): Item(I8, **actual),
        (0x6064, 0): Item(I32, **actual),
        (0x6065, 0): Item(U32, default=2000),
        (0x6066, 0): Item(U16, default=10),
        (0x607A, 0): Item(I32, **target),
        (0x607D, 1): Item(I32),
        (0x607D, 2): Item(I32),
        (0x6085, 0): Item(U32, default=100_000),
        (0x60C1, 1): Item(I32, **target),
        (0x60C2, 1): Item(U8, default=1),
        (0x60C2, 2): Item(I8, default="0xFD"),
        (0x6502, 0): Item(U32, "ro", modes),
    }


TORQUE: Items = {(0x6076, 0): Item(U32, default=RATED_TORQUE), (0x6077, 0): Item(I16, "ro", mappable=True)}
CURRENT: Items = {(0x6075, 0): Item(U32, default=RATED_CURRENT), (0x6078, 0): Item(I16, "ro", mappable=True)}


def _encoder(increments: int, gear: int, feed: int) -> dict[Address, Item]:
    values = {0x608F: (increments, 1), 0x6091: (gear, 1), 0x6092: (feed, 1)}
    return {(index, sub + 1): Item(U32, default=pair[sub]) for index, pair in values.items() for sub in (0, 1)}


OTHER_VOLTAGES: Items = {
    (0x2000 + i, 0): Item(I16, "ro", mappable=True, name=name)
    for i, name in enumerate(("Analog output 1 voltage [mV]", "Voltage phase A [mV]", "Motor supply voltage [mV]"))
}


def _without(items: Items, *indices: int) -> dict[Address, Item]:
    return {address: item for address, item in items.items() if address[0] not in indices}


def _wilful() -> MadeUpDrive:
    units = {(0x60A9, 0): Item(U32, default=RPM), (0x60AA, 0): Item(U32, default=RPM_PER_SECOND)}
    items = base() | TORQUE | units | {(0x605A, 0): Item(I16, default=6)}
    return MadeUpDrive(
        items,
        {
            "refuse_write": ["1006"],
            "allowed": {"605A": [6], "6066": [0]},
            "values": {"6066": 0},
            "referenced_mask": 0x8000,
            "reset_after_heartbeat_loss": False,
            "fault_on_heartbeat_loss": True,
        },
    )


def _slow() -> MadeUpDrive:
    older = {(0x6093, sub): Item(U32, default=1) for sub in (1, 2)}
    older |= {(0x608E, 0): Item(U8, default=0xAE), (0x608D, 0): Item(I8, default=0)}
    items = _without(base(modes=0x43), 0x607A) | TORQUE | four_tpdos() | older
    return MadeUpDrive(items, {"fault_reset": 0.1, "enabling": 0.2, "cob_id_bits": 0x4000_0000})


MADE_UP: dict[str, MadeUpDrive] = {
    # Refuses 1006h, knows only 605Ah = 6, no usable 6066h, 60AAh = rpm/s, "referenced" in bit 15, and after the loss
    # of its master a fault that only NMT "reset communication" makes resettable.
    "wilful": _wilful(),
    # A 32-bit voltage in millivolts, and four TPDOs from power-up on.
    "wide_voltage": MadeUpDrive(
        base() | four_tpdos() | {(0x2030, 0): Item(I32, "ro", mappable=True, name="Motor voltage [mV]")},
        {"voltage": "2030", "voltage_scale": 0.001},
    ),
    # Accepts only 1 ms in 60C2h; current instead of voltage; positions in thousandths of a degree of the shaft.
    "one_millisecond": MadeUpDrive(
        base()
        | CURRENT
        | {(0x6076, 0): Item(U32, default=RATED_TORQUE)}
        | _encoder(INCREMENTS_PER_TURN, GEAR, 360_000 * GEAR)
        | {(0x60C2, 1): Item(U8, default=1, low=1, high=1), (0x60AA, 0): Item(U32, default=0x0041_5700)}
    ),
    # 608Fh and factors that nobody has set: positions are increments. Voltages that are not the motor's.
    "unset_factors": MadeUpDrive(
        base()
        | TORQUE
        | _encoder(INCREMENTS_PER_TURN, 1, 1)
        | OTHER_VOLTAGES
        | {(0x60AA, 0): Item(U32, default=RPM_PER_SECOND)},
        {"position_in_increments": True},
    ),
    # Speeds in rpm, a dimension index of speed for accelerations, which are increments/s^2; no torque, but a current.
    "older_speed": MadeUpDrive(
        base()
        | CURRENT
        | OTHER_VOLTAGES
        | {(0x60A9, 0): Item(U32, default=RPM), (0x608E, 0): Item(U8, default=0xA4), (0x608D, 0): Item(I8)}
    ),
    # Nothing to find the torque from.
    "outputs_only": MadeUpDrive(base() | OTHER_VOLTAGES),
    # Profile position, profile velocity, homing: nothing that follows a target every cycle.
    "profile_only": MadeUpDrive(base(modes=0x25) | TORQUE),
    # 100 ms for a fault reset, interpolated position only, units of DSP 402 2.0, bit 30 set in every COB-ID.
    "slow": _slow(),
}


OPTIONAL = (0x1006, 0x1008, 0x1014, 0x1016, 0x1018, 0x6007, 0x603F, 0x605A, 0x605D, 0x605E, 0x6065, 0x6066)
OPTIONAL += (0x607D, 0x6085, 0x60C2, 0x6502, 0x1005, 0x1017)


@st.composite
def made_up_drives(draw: st.DrawFn) -> MadeUpDrive:
    """A drive with objects present or absent, limits, sizes, units and default PDOs at random."""
    items = base(modes=draw(st.sampled_from([0, 0xC0, 0x80, 0x40, 0x3C1, 0x25])))
    items = _without(items, *draw(st.lists(st.sampled_from(OPTIONAL), unique=True, max_size=4)))
    habits: dict[str, Any] = {}
    if draw(st.booleans()):
        items |= four_tpdos(draw(st.sampled_from([1, 254, 255])))
    match draw(st.sampled_from(["voltage", "torque", "current"])):
        case "voltage":
            size = draw(st.sampled_from([I16, I32]))
            unit, scale = draw(st.sampled_from([("[mV]", 0.001), ("0.1 V", 0.1), ("1 mV", 0.001)]))
            items[0x2030, 0] = Item(size, "ro", mappable=draw(st.booleans()), name=f"Motor voltage {unit}")
            habits |= {"voltage": "2030", "voltage_scale": scale}
        case "torque":
            items |= TORQUE
        case "current":
            items |= {**CURRENT, **TORQUE}
            del items[0x6077, 0]
    items |= draw(_units())
    if draw(st.booleans()):
        habits |= {"fault_reset": draw(st.sampled_from([0.05, 0.1]))}
    if draw(st.booleans()):
        habits |= {"cob_id_bits": 0x4000_0000}
    if (0x605A, 0) in items and draw(st.booleans()):
        habits |= {"allowed": {"605A": [6]}, "values": {"605A": 6}}
    for address in [(0x6065, 0), (0x6085, 0)]:
        if address in items and draw(st.booleans()):
            items[address] = replace(items[address], low=0, high=draw(st.sampled_from([0xFFFF, 0x7FFF_FFFF])))
    return MadeUpDrive(items, habits)


@st.composite
def _units(draw: st.DrawFn) -> dict[Address, Item]:
    codes = [0, RPM_PER_SECOND, 0x00B4_4703, 0x0010_5700, 0x0041_5700, 0xFD10_5700, 0x00B5_5700]
    items = {(0x60AA, 0): Item(U32, default=draw(st.sampled_from(codes)))}
    if draw(st.booleans()):
        items |= _encoder(INCREMENTS_PER_TURN, *draw(st.sampled_from([(1, 8192), (GEAR, 8192 * GEAR), (1, 36_000)])))
    elif draw(st.booleans()):
        items |= {(0x6093, sub): Item(U32, default=1) for sub in (1, 2)}
    return items
