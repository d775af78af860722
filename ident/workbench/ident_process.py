"""Commands of `ident` that the page runs as separate processes, so that it never waits for their libraries."""

import subprocess
import sys
from pathlib import Path

from ident.workbench.recording_process import errors


def run_ident(root: Path, *words: str) -> str | None:
    """Run `ident` with `words` in the folder `root`; return the error that it ends with."""
    process = subprocess.run(
        [sys.executable, "-c", "from ident.cli import main; main()", *words],
        cwd=root,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
    )
    if process.returncode == 0:
        return None
    reason = " ".join(errors(process.stderr.splitlines()))
    return reason or f"`ident {words[0]}` ended with exit status {process.returncode}"
