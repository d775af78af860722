"""Self-test of an adapter and its host: how late cycles begin, how soon answers come, what becomes of frames.

The cycle of a recording, SYNC at the rate of the rig, with drives that are set up and have no power.
"""

import math
import time
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence

from drivers.canopen.bus import Link
from drivers.protocol import CheckResult, Sample, Verdict
from recordings.rig import Rig

_BINS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
"""Upper ends of the histogram [ms]; a last bin holds the rest."""
_MOST_LOST = 0.01
"""Share of the answers of a joint that may be missing, as in a recording that ends without a warning."""
_ANSWER_SHARE = 0.8
"""Share of the period in which answers are waited for."""


def self_test(
    rig: Rig, link: Link, exchange: Callable[[None, float], Sample], duration: float
) -> Iterator[CheckResult]:
    """Run the cycle for `duration` [s] by `exchange`, see `Amplifiers`.

    Raises:
        RunFailed: the bus is lost.
    """
    before, period = link.bits, 1 / rig.rate
    lateness, delays, lost = list[float](), list[float](), [0] * rig.dof
    start = time.perf_counter()
    for cycle in range(1, max(2, round(duration * rig.rate)) + 1):
        due = start + cycle * period
        time.sleep(max(0.0, due - time.perf_counter()))
        begin = time.perf_counter()
        lateness.append(1e3 * (begin - due))
        sample = exchange(None, _ANSWER_SHARE * period)
        lost = [count + math.isnan(position) for count, position in zip(lost, sample.position, strict=True)]
        delays.append(1e3 * (time.perf_counter() - begin))

    def row(what: str, expected: str, found: str, verdict: Verdict = "noted") -> CheckResult:
        return CheckResult("bus", f"self-test: {what}", expected, found, verdict)

    own = f"{link.echoes} came back and are told from those of others" if link.echoes else "none come back"
    yield row("own frames", "not taken for those of others", own)
    stamps = "of the host's clock" if link.stamped else "those of this program"
    yield row("time stamps", "of the kernel or adapter", stamps)
    load = (link.bits - before) / rig.can.bitrate / (time.perf_counter() - start)
    yield row("load", f"at most {rig.can.max_load:.0%}", f"{load:.1%}")
    text, is_late = (
        f"{_histogram(lateness)}; largest {max(lateness):.2f} ms",
        max(lateness) > 1e3 * rig.limits.host_stall,
    )
    yield row("lateness of SYNC", f"below {1e3 * period:.3g} ms", text, "problem" if is_late else "noted")
    missing = ", ".join(f"joint {joint}: {count}" for joint, count in enumerate(lost, start=1) if count)
    text = f"{_histogram(delays)}; largest {max(delays):.2f} ms; of {len(delays)} missing: {missing or 'none'}"
    is_deaf = max(lost) > _MOST_LOST * len(delays)
    yield row("answers", f"after less than {1e3 * period:.3g} ms", text, "problem" if is_deaf else "noted")


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
