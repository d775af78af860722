"""Node id and bit rate of a device by LSS (CiA 305), which needs no node id to begin with."""

import struct
from collections.abc import Sequence

from drivers.canopen.bus import Link
from recordings.errors import BadInput, RunFailed

BIT_RATES = {1_000_000: 0, 800_000: 1, 500_000: 2, 250_000: 3, 125_000: 4, 50_000: 6, 20_000: 7, 10_000: 8}
"""Index in the table of CiA 305 by bit rate [bit/s]."""
_MASTER, _SLAVE = 0x7E5, 0x7E4
_SWITCH_ALL, _CONFIGURE, _WAIT = 0x04, 1, 0
_SWITCH_ONE, _SWITCHED = 0x40, 0x44
_NODE_ID, _BIT_RATE, _STORE = 0x11, 0x13, 0x17
_INQUIRE = range(0x5A, 0x5E)
"""Vendor, product, revision and serial number."""
_TIMEOUT = 0.3
"""Time that a device may take to answer [s]."""
_LATER = 0.05
"""Time in which a second device would answer, too [s]."""

Identification = tuple[int, int, int, int]
"""Vendor, product, revision and serial number (1018h)."""


def configure(link: Link, device: Identification | None, node_id: int, bit_rate: int | None) -> Identification:
    """Give a device its node id and, if any, its bit rate [bit/s], and let it store them; returns which device it is.

    `device`: None where it is the only one on the bus. Both take effect when its supply is switched off and on.

    Raises:
        BadInput: a bit rate that LSS does not have.
        RunFailed: no device answers, more than one does, or it refuses; none is left waiting for configuration.
    """
    if bit_rate is not None and bit_rate not in BIT_RATES:
        raise BadInput(f"--bitrate: one of {', '.join(map(str, BIT_RATES))} bit/s expected, {bit_rate} found")
    try:
        if device is None:
            _send(link, _SWITCH_ALL, _CONFIGURE)
            device = _identify(link)
        else:
            for offset, number in enumerate(device):
                _send(link, _SWITCH_ONE + offset, *struct.pack("<I", number))
            if not _answers(link, _SWITCHED):
                raise RunFailed("no device with this identity answers LSS; compare all four numbers of 1018h")
        _order(link, "node id", _NODE_ID, node_id)
        if bit_rate is not None:
            _order(link, "bit rate", _BIT_RATE, 0, BIT_RATES[bit_rate])
        _order(link, "storing", _STORE)
    finally:
        _send(link, _SWITCH_ALL, _WAIT)
    return device


def _identify(link: Link) -> Identification:
    numbers = []
    for command in _INQUIRE:
        _send(link, command)
        answers = _answers(link, command)
        if len(answers) != 1:
            found = "none" if not answers else "several"
            raise RunFailed(
                f"one device that answers LSS expected, {found} found; leave only this one on the bus, at its bit "
                "rate, or name it by --device"
            )
        numbers.append(struct.unpack_from("<I", answers[0], 1)[0])
    vendor, product, revision, serial = numbers
    return vendor, product, revision, serial


def _order(link: Link, what: str, command: int, *values: int) -> None:
    _send(link, command, *values)
    answers = _answers(link, command)
    if not answers:
        raise RunFailed(f"the device does not answer ({what}); try again, or use the tool of its maker")
    if answers[0][1]:
        raise RunFailed(f"the device refuses: {what}, LSS error {answers[0][1]}; see its manual")


def _send(link: Link, command: int, *values: int) -> None:
    link.send(_MASTER, bytes([command, *values]).ljust(8, b"\0"))


def _answers(link: Link, command: int) -> Sequence[bytes]:
    """Data of all answers to a command."""
    found: list[bytes] = []
    for duration in (_TIMEOUT, _LATER):
        for arbitration_id, data in link.frames(duration):
            if arbitration_id == _SLAVE and len(data) == 8 and data[0] == command:
                found.append(data)
                break
        else:
            break  # Where nobody has answered, nobody answers later.
    return found
