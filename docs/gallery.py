"""The gallery: examples that run while its page is built, each shown with what it printed and with its picture."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

EXAMPLES = Path(__file__).parent / "examples"
SAMPLES = Path(__file__).parent.parent / "recordings" / "samples"
LIMIT = 600
"""Longest run of an example [s]."""


def run(name: str, folder: Path) -> str:
    """Run the example `name` in a new `folder`, beside the sample recordings; return what it printed.

    Raises:
        RuntimeError: it failed, or drew no picture.
    """
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(EXAMPLES, folder)
    for sample in SAMPLES.glob("*.mcap"):
        shutil.copy(sample, folder)
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(
        [sys.executable, f"{name}.py"],
        cwd=folder,
        env=os.environ | {"PATH": path, "MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
        timeout=LIMIT,
    )
    if done.returncode or not (folder / f"{name}.png").is_file():
        raise RuntimeError(f"example {name}: a picture expected, failure found: {done.stderr}")
    return done.stdout


def shown(name: str, folder: Path, link: str) -> str:
    """The example `name`, run in `folder`, as Markdown; `link`: `folder` as seen from the page."""
    printed = run(name, folder)
    source = (EXAMPLES / f"{name}.py").read_text(encoding="utf-8")
    return f"```python\n{source}```\n\n```text\n{printed}```\n\n![Picture of {name}]({link}/{name}.png)"
