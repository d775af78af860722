"""The program `ident`, which `daq` starts as a process and never imports."""

import sys

IDENT = (sys.executable, "-c", "from ident.cli import main; main()")
"""Beginning of its command line."""
