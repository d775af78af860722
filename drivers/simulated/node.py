"""The object dictionary of a simulated drive, served by canopen's LocalNode."""

import logging
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import canopen

EDS = Path(__file__).with_name("drive.eds")

Send = Callable[[int, bytes], None]


class _SendOnly:
    """The part of a network that LocalNode uses."""

    def __init__(self, send: Send) -> None:
        self._send = send

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        self._send(can_id, bytes(data))


@cache
def _dictionary(node_id: int) -> Any:
    """Object dictionary, parsed once because parsing is slow. The values are stored in the node."""
    return canopen.import_od(str(EDS), node_id)


def local_node(node_id: int, send: Send) -> Any:
    """A node with the values of its EDS, which answers through `send` without a thread."""
    # canopen logs every request that it also refuses on the bus.
    logging.getLogger("canopen").setLevel(logging.CRITICAL)
    node: Any = canopen.LocalNode(node_id, _dictionary(node_id))
    node.sdo.network = node.emcy.network = _SendOnly(send)
    # canopen's server can refuse a segment without a transfer only if these are numbers.
    node.sdo._index = node.sdo._subindex = 0
    # canopen's heartbeat runs on the host's clock, the drive's on simulated time.
    node.nmt.start_heartbeat = lambda milliseconds: None
    return node
