"""Self-test of a CAN adapter: how late its host is, how soon answers come, and what the adapter does with frames.

One SDO request a cycle goes to a drive, as a recording would send SYNC; nothing is written and nothing moves.
"""

import time
from bisect import bisect_left
from collections.abc import Iterator, Sequence

from drivers.canopen.bus import Link, frame_bits
from drivers.canopen.sdo import READ_DEVICE_TYPE
from drivers.protocol import CheckResult, Verdict
from recordings.rig import Rig

_BINS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
"""Upper ends of the histogram [ms]; a last bin holds the rest."""


def self_test(rig: Rig, link: Link, duration: float) -> Iterator[CheckResult]:
    """Exchange one request and answer in each cycle for `duration` [s].

    Raises:
        RunFailed: the bus is lost.
    """
    lateness, delays, frames = _exchange(rig, link, duration)
    cycles, period = len(lateness), 1e3 / rig.rate

    def row(what: str, expected: str, found: str, verdict: Verdict = "noted") -> CheckResult:
        return CheckResult("bus", f"self-test: {what}", expected, found, verdict)

    own = f"{link.echoes} came back and are told from those of others" if link.echoes else "none come back"
    yield row("own frames", "not taken for those of others", own)
    yield row(
        "time stamps", "of the kernel or adapter", "of the host's clock" if link.stamped else "those of this program"
    )
    yield row("load", f"at most {rig.can.max_load:.0%}", f"{frames * frame_bits(8) / rig.can.bitrate / duration:.1%}")
    late = max(lateness)
    allowed = rig.limits.host_stall * 1e3
    text = f"{_histogram(lateness)}; largest {late:.2f} ms"
    yield row("lateness", f"below {period:.3g} ms", text, "noted" if late <= allowed else "problem")
    if not delays:
        yield row("answers", f"{cycles} in time", "none", "problem")
        return
    lost = f", {cycles - len(delays)} of {cycles} not within a cycle" if len(delays) < cycles else ""
    yield row(
        "answers", f"after less than {period:.3g} ms", f"{_histogram(delays)}; largest {max(delays):.2f} ms{lost}"
    )


def _exchange(rig: Rig, link: Link, duration: float) -> tuple[list[float], list[float], int]:
    """Lateness of each cycle and delay of each answer [ms], and the number of frames."""
    node, lateness, delays = rig.drives[0].node_id, list[float](), list[float]()
    before, sent = link.received, max(2, round(duration * rig.rate))
    start = time.perf_counter()
    for cycle in range(1, sent + 1):
        due = start + cycle / rig.rate
        time.sleep(max(0.0, due - time.perf_counter()))
        begin = time.perf_counter()
        lateness.append((begin - due) * 1e3)
        link.send(0x600 + node, READ_DEVICE_TYPE)
        for arbitration_id, _ in link.frames(due + 0.8 / rig.rate - time.perf_counter()):
            if arbitration_id == 0x580 + node:
                delays.append((time.perf_counter() - begin) * 1e3)
                break
    return lateness, delays, sent + link.received - before


def _histogram(milliseconds: Sequence[float]) -> str:
    """Shares of the values by their size, without empty bins."""
    counts = [0] * (len(_BINS) + 1)
    for value in milliseconds:
        counts[bisect_left(_BINS, value)] += 1
    names = [*(f"to {end:g}" for end in _BINS), f"over {_BINS[-1]:g}"]
    shares = (
        f"{name} ms {count / len(milliseconds):.1%}" for name, count in zip(names, counts, strict=True) if count
    )
    return ", ".join(shares)
