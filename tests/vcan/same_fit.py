"""Check that `ident fit` on a recording and on a listener's recording of its replay gives the same parameters.

    python -m tests.vcan.same_fit first.mcap second.mcap

Run this outside User-mode Linux, after the recordings were made on vcan0.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from recordings.reader import read
from tests.conftest import launcher

TOLERANCE = 1e-9
"""Relative tolerance: the stamps of both recordings come from the SYNC index."""


def parameters(recording: str, folder: str) -> dict[str, float]:
    """What `ident fit` finds in a recording."""
    command = [
        *launcher("ident"),
        "fit",
        recording,
        "-o",
        f"{folder}/model.json",
        "--force",
    ]
    done = subprocess.run([*command, "--json"], capture_output=True, text=True, check=True)
    return {parameter["name"]: parameter["value"] for parameter in json.loads(done.stdout)["parameters"]}


def main(first: str, second: str) -> int:
    """Exit code 0 if all parameters agree, or if the times differ, so that the fits cannot agree."""
    sent, listened = (np.diff(read(Path(file)).time) for file in (first, second))
    if len(sent) != len(listened) or not np.allclose(sent, listened, rtol=TOLERANCE, atol=0.0):
        periods = (
            f"{len(listened)} periods of {np.median(listened):.6f} s, not {len(sent)} of {np.median(sent):.6f} s"
        )
        print(f"this machine does not keep time: the listener recorded {periods}. The fits are not compared")
        return 0
    with tempfile.TemporaryDirectory() as folder:
        reference, replayed = parameters(first, folder), parameters(second, folder)
    worst = max(abs(replayed[name] / reference[name] - 1) for name in reference)
    print(
        f"ident fit on the recording and the listener's: {len(reference)} parameters, "
        f"worst relative difference {worst:.1e}"
    )
    return int(worst > TOLERANCE)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
