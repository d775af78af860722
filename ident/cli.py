"""`ident`: identify the dynamic model of a recorded mechanism."""

import gc
import os
import signal
import sys

_COLLECTED = 50_000
"""New objects after which unused cycles of objects are searched."""


def main() -> None:
    """Entry point of the program `ident`."""
    # Matrices are long and narrow: BLAS threads would mostly wait for each other and keep the cores busy.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # Libraries and results are many objects that stay: searching them often for unused cycles takes 4 % of the time.
    gc.set_threshold(_COLLECTED)
    try:
        # Here, because Ctrl-C may come while they are imported, which takes a moment.
        from ident.program import answer
        from recordings.command_line import run
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        sys.exit(128 + signal.SIGINT)
    run(answer)
