"""Draw a share of the slow tests: whole modules, whose fixtures are shared, chosen by a digest.

`--share 1/5 --draw DIGEST` runs one fifth; the same digest always draws the same. The tests marked `essential` always
run. Each module has one of N buckets, so that N neighbouring digests do not matter: the N shares are disjoint, and
together they are all.
"""

import hashlib
from collections.abc import Callable

import pytest


def bucket(name: str, count: int) -> int:
    """Bucket of a module or a digest: the same in all processes, as `hash` is not."""
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:8]) % count


def parsed(share: str) -> tuple[int, int]:
    """Numerator and denominator of a share such as "1/5".

    Raises:
        pytest.UsageError: it is none.
    """
    numbers = share.split("/")
    if len(numbers) != 2 or not all(map(str.isdecimal, numbers)) or not 1 <= int(numbers[0]) <= int(numbers[1]):
        raise pytest.UsageError(f"--share: expected a share such as 1/5, found {share!r}")
    return int(numbers[0]), int(numbers[1])


def drawn(share: str, digest: str) -> Callable[[str], bool]:
    """Return whether a module of that name is in the share that a digest draws; errors as `parsed`."""
    taken, count = parsed(share)
    first = bucket(digest, count)
    return lambda module: (bucket(module, count) - first) % count < taken


def keep_share(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Deselect the slow tests that are not drawn; see the module."""
    share, digest = config.getoption("--share"), config.getoption("--draw")
    is_drawn = drawn(share, digest)
    kept, left = list[pytest.Item](), list[pytest.Item]()
    for item in items:
        always = not item.get_closest_marker("slow") or item.get_closest_marker("essential")
        (kept if always or is_drawn(item.nodeid.partition("::")[0]) else left).append(item)
    if left:
        config.hook.pytest_deselected(items=left)
    items[:] = kept
