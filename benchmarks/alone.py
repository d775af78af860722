"""One benchmark: `python -m benchmarks.alone NAME`. Exit code 75: something did not answer in time."""

import importlib
import sys
from collections.abc import Callable

from recordings.errors import RunFailed

TOO_LATE = 75
"""Of sysexits.h: try again later."""


def run(main: Callable[[], object]) -> int:
    """Run a benchmark; returns the exit code."""
    try:
        main()
    except Exception as error:
        if not _too_late(error):
            raise
        print(" ".join(str(error).split()), file=sys.stderr)
        return TOO_LATE
    return 0


def _too_late(error: Exception) -> bool:
    """Whether it can come from a machine that is busy: a run that ended early, or anybody's timeout."""
    kinds = [kind.__name__ for kind in type(error).__mro__]
    return isinstance(error, RunFailed) or any("Timeout" in kind or kind == "SdoCommunicationError" for kind in kinds)


if __name__ == "__main__":
    sys.exit(run(importlib.import_module(f"benchmarks.{sys.argv[1]}").main))
