"""Draw a share of the tests: whole modules, whose fixtures are shared, chosen by a digest.

`--share 1/5 --draw DIGEST` runs one fifth; the same digest always draws the same. What is marked `essential` always
runs. Each module has one of five buckets, and so has a digest: five shares are disjoint, and together they are all.
`--one-in 4` draws from the variations of a test, its parameters, in the same way.
"""

import hashlib
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest

_ESSENTIAL = "mark.essential"
"""What a module says that has such tests."""


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


def check(config: pytest.Config) -> None:
    """Check what is to be drawn.

    Raises:
        pytest.UsageError: it says no share, or no number of variations.
    """
    parsed(config.getoption("--share"))
    if config.getoption("--one-in") < 1:
        raise pytest.UsageError(f"--one-in: expected 1 or more, found {config.getoption('--one-in')}")


def is_left_out(config: pytest.Config, path: Path) -> bool:
    """Whether a module is not drawn and has nothing essential: it is not even imported, which would take longest."""
    is_module = path.suffix == ".py" and path.name.startswith("test_")
    return is_module and not _is_drawn(config, path) and _ESSENTIAL not in path.read_text(encoding="utf-8")


def keep_drawn(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Keep what is essential and, of the modules that are drawn, one in `--one-in` variations of each test."""
    variations = Counter(map(_test, items))
    turn, seen = bucket(config.getoption("--draw"), 2**32), Counter[tuple[str, bool]]()
    kept, left = list[pytest.Item](), list[pytest.Item]()
    for item in items:
        count = min(config.getoption("--one-in"), variations[_test(item)])
        has_turn = seen[_test(item)] % count == turn % count
        seen[_test(item)] += 1
        taken = item.get_closest_marker("essential") or (has_turn and _is_drawn(config, item.path))
        (kept if taken else left).append(item)
    if left:
        config.hook.pytest_deselected(items=left)
    items[:] = kept


def _test(item: pytest.Item) -> tuple[str, bool]:
    """Name of a test without the parameters of a variation; fast and slow ones are drawn apart."""
    return item.nodeid.partition("[")[0], item.get_closest_marker("slow") is not None


def _is_drawn(config: pytest.Config, path: Path) -> bool:
    return drawn(config.getoption("--share"), config.getoption("--draw"))(str(path.relative_to(config.rootpath)))
