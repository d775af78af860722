"""Data problems: what cannot be right about recordings. One kind is one module, found by its name.

Each has a function `find(facts)` that returns the problem, or None.
"""

from collections.abc import Iterator

from ident import plugins
from ident.data_problems.facts import Facts
from recordings.data_problems import DataProblem

_KINDS = "ident.data_problems.kinds"


def problems(facts: Facts) -> Iterator[DataProblem]:
    """Yield the problems of recordings, by kind in alphabetical order."""
    for name in plugins.names(_KINDS):
        found = plugins.load(_KINDS, name).find(facts)
        if found is not None:
            yield found
