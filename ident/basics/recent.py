"""A small cache: the results that were used last."""

from collections.abc import Callable, Hashable
from threading import Lock
from typing import TypeVar, cast

_T = TypeVar("_T")


class RecentResults:
    """Results by key, of which the `size` last used ones are kept. Several threads may use it at the same time."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._results: dict[Hashable, object] = {}
        """In the order of use."""
        self._lock = Lock()

    def __reduce__(self) -> tuple[type["RecentResults"], tuple[int]]:
        """An empty one in another process."""
        return RecentResults, (self._size,)

    def get(self, key: Hashable, compute: Callable[[], _T]) -> _T:
        """Return the result of this `key`, or of `compute`, which two threads may call for the same key."""
        result = self.find(key)
        return self.keep(key, compute()) if result is None else cast(_T, result)

    def find(self, key: Hashable) -> object | None:
        """Return the result of this `key`, or None if it is not kept."""
        with self._lock:
            if key in self._results:
                self._results[key] = self._results.pop(key)
            return self._results.get(key)

    def keep(self, key: Hashable, result: _T) -> _T:
        """Keep the `result`, which is not None, in place of the one that was used least recently."""
        with self._lock:
            self._results.pop(key, None)
            if len(self._results) >= self._size:
                del self._results[next(iter(self._results))]
            self._results[key] = result
        return result
