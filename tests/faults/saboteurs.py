"""Saboteurs of frames on a cable for `bridge.Bridge`. Faults begin at SYNC number `START`."""

from collections.abc import Callable, Iterable

import can

from tests.faults.bridge import Saboteur

START = 700
"""Number of a SYNC in mid-motion."""

TPDO_2, RPDO_2, SYNC = 0x182, 0x202, 0x080


def changed(message: can.Message, *, arbitration_id: int | None = None, data: bytes | None = None) -> can.Message:
    """The same frame with another id or other data."""
    return can.Message(
        arbitration_id=message.arbitration_id if arbitration_id is None else arbitration_id,
        data=message.data if data is None else data,
        is_extended_id=False,
    )


def on(arbitration_id: int, act: Callable[[can.Message], Iterable[can.Message]], *, count: int = 10**9) -> Saboteur:
    """Apply `act` to the first `count` frames with that id from START on."""
    done = 0

    def saboteur(message: can.Message, from_master: bool, syncs: int) -> Iterable[can.Message]:
        nonlocal done
        if message.arbitration_id != arbitration_id or syncs < START or done >= count:
            return (message,)
        done += 1
        return act(message)

    return saboteur


def drop(arbitration_id: int, count: int = 10**9) -> Saboteur:
    """Drop frames."""
    return on(arbitration_id, lambda message: (), count=count)


def double(arbitration_id: int) -> Saboteur:
    """Send frames twice."""
    return on(arbitration_id, lambda message: (message, message))


def delay(arbitration_id: int, count: int = 10**9) -> Saboteur:
    """Delay frames until the next frame with the same id."""
    kept: list[can.Message] = []

    def act(message: can.Message) -> Iterable[can.Message]:
        kept.append(message)
        return (kept.pop(0),) if len(kept) > 1 else ()

    return on(arbitration_id, act, count=count)


def alter(arbitration_id: int, change: Callable[[bytes], bytes], count: int = 10**9) -> Saboteur:
    """Change the data of frames."""
    return on(arbitration_id, lambda message: (changed(message, data=change(bytes(message.data))),), count=count)


def reorder(first: int, second: int) -> Saboteur:
    """Exchange two frames of a cycle."""
    kept: list[can.Message] = []

    def saboteur(message: can.Message, from_master: bool, syncs: int) -> Iterable[can.Message]:
        if syncs < START:
            return (message,)
        if message.arbitration_id == first:
            kept.append(message)
            return ()
        if message.arbitration_id == second:
            delayed = tuple(kept)
            kept.clear()
            return (message, *delayed)
        return (message,)

    return saboteur


def accompany(
    arbitration_id: int, additional: Callable[[int], Iterable[can.Message]], *, first: int = START
) -> Saboteur:
    """Insert additional frames, made from the SYNC count, before every frame with that id."""

    def saboteur(message: can.Message, from_master: bool, syncs: int) -> Iterable[can.Message]:
        if message.arbitration_id != arbitration_id or syncs < first:
            return (message,)
        return (*additional(syncs), message)

    return saboteur
