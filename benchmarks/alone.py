"""Run one benchmark: `python -m benchmarks.alone NAME`. Exit code 75: a timeout."""

import importlib
import sys
from collections.abc import Callable

from recordings.errors import RunFailed

TOO_LATE = 75
"""EX_TEMPFAIL of sysexits.h."""


def run(main: Callable[[], object]) -> int:
    """Run the `main` of a benchmark; return the exit code."""
    try:
        main()
    except Exception as error:
        if not _is_timeout(error):
            raise
        print(" ".join(str(error).split()), file=sys.stderr)
        return TOO_LATE
    return 0


def _is_timeout(error: Exception) -> bool:
    """Whether a busy machine can cause this error: a run that ended early, or a timeout of any library."""
    kinds = [kind.__name__ for kind in type(error).__mro__]
    return isinstance(error, RunFailed) or any("Timeout" in kind or kind == "SdoCommunicationError" for kind in kinds)


if __name__ == "__main__":
    sys.exit(run(importlib.import_module(f"benchmarks.{sys.argv[1]}").main))
