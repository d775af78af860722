"""Compute in this process, one item after the other."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from ident.fleet.engines import EngineOptions

T = TypeVar("T")
R = TypeVar("R")


def run(function: Callable[[T], R], items: Sequence[T], options: EngineOptions) -> Iterator[tuple[T, R | None]]:
    """See `Engine`; numpy and numba may use all processors."""
    for item in items:
        yield item, function(item)
