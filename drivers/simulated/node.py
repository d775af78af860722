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
    """What LocalNode's parts need of a network."""

    def __init__(self, send: Send) -> None:
        self._send = send

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        self._send(can_id, bytes(data))


@cache
def _dictionary(node_id: int) -> Any:
    """Read once: a drive boots faster than its EDS is parsed. Values live in the node, not here."""
    return canopen.import_od(str(EDS), node_id)


def local_node(node_id: int, send: Send) -> Any:
    """A node with the values of its EDS, which answers through `send` and in nobody's thread."""
    # canopen logs every request that it also refuses over the bus.
    logging.getLogger("canopen").setLevel(logging.CRITICAL)
    node: Any = canopen.LocalNode(node_id, _dictionary(node_id))
    node.sdo.network = node.emcy.network = _SendOnly(send)
    # canopen's server cannot refuse a segment that no transfer has announced unless these are numbers.
    node.sdo._index = node.sdo._subindex = 0
    # canopen's heartbeat runs on the host's clock; the drive's on simulated time.
    node.nmt.start_heartbeat = lambda milliseconds: None
    return node
