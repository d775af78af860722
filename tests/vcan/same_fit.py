"""`ident fit` on a recording and on what a listener made of its replay gives the same parameters.

    python -m tests.vcan.same_fit first.mcap second.mcap

Run where numpy is fast, after the recordings were made on vcan0.
"""

import json
import subprocess
import sys
import tempfile

from tests.conftest import launcher

TOLERANCE = 1e-9
"""Relative: the stamps of both come from the SYNC index."""


def parameters(recording: str, folder: str) -> dict[str, float]:
    """What `ident fit` finds in a recording."""
    command = [
        *launcher("ident"),
        "fit",
        recording,
        "-o",
        f"{folder}/model.json",
        "--plots",
        f"{folder}/plots",
        "--force",
    ]
    done = subprocess.run([*command, "--json"], capture_output=True, text=True, check=True)
    return {parameter["name"]: parameter["value"] for parameter in json.loads(done.stdout)["parameters"]}


def main(first: str, second: str) -> int:
    """Exit code 0 where all parameters agree."""
    with tempfile.TemporaryDirectory() as folder:
        one, other = parameters(first, folder), parameters(second, folder)
    worst = max(abs(other[name] / one[name] - 1) for name in one)
    print(
        f"ident fit on the recording and the listener's: {len(one)} parameters, worst relative difference {worst:.1e}"
    )
    return int(worst > TOLERANCE)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
