"""Does the motion of `ident design --discriminate` settle what one recording could not? As a user would do it.

An effect is hidden in the simulated rig, fig5a is recorded and diagnosed. Where the finding could be something else,
the motion that tells the two apart is designed and recorded, and both recordings are diagnosed together.
"""

import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from benchmarks.demo import program

HIDDEN = (
    ("arm_mass_mismatch", 0.01, [2]),
    ("torque_gain_mismatch", 0.01, [2]),
    ("encoder_zero_offset", 0.01, [2]),
    ("joint_spring", 0.01, [2]),
    ("arm_com_offset", 0.01, [2]),
    ("torque_map_exponent", 0.01, [1, 2, 3]),
)
"""Effects, their sizes over the torque, and joints."""


def main() -> None:
    """Print one line for each hidden effect."""
    for effect, size, joints in HIDDEN:
        with tempfile.TemporaryDirectory() as folder:
            print(f"discriminate: {effect} {size:.0%}: {_story(Path(folder), effect, size, joints)}", flush=True)


def _story(folder: Path, effect: str, size: float, joints: list[int]) -> str:
    sim = folder / "sim.toml"
    sim.write_text(f'[[effects]]\nname = "{effect}"\nsize = {size}\njoints = {joints}\n', encoding="utf-8")
    first = _recorded("fig5a", sim, folder / "first.mcap")
    found = _found([first])
    said = ", ".join(_words(one) for one in found) or "nothing"
    unsure = next((one for one in found if one["confusable_with"]), None)
    if unsure is None:
        return f"fig5a alone says {said}"
    pair = unsure["effect"], unsure["confusable_with"][0]
    motion = folder / "next.toml"
    try:
        _run("ident", "design", "--discriminate", *pair, "-o", motion)
    except subprocess.CalledProcessError as failed:
        return f"fig5a says {said}; no motion that tells {' from '.join(pair)}: {failed.stderr.strip()}"
    both = _found([first, _recorded(motion, sim, folder / "second.mcap")])
    after = ", ".join(_words(one) for one in both) or "nothing"
    right = [one["effect"] for one in both] == [effect] and not both[0]["confusable_with"]
    return (
        f"fig5a says {said}; with the motion that tells {' from '.join(pair)}: {after} ({'right' if right else 'no'})"
    )


def _recorded(motion: object, sim: Path, out: Path) -> Path:
    _run("daq", "record", "--traj", motion, "--sim", sim, "--out", out)
    return out


def _found(files: list[Path]) -> list[dict[str, Any]]:
    """What is named beside the forearms' inertia."""
    said = _run("ident", "diagnose", *files, "--json", "--force")
    return [one for one in json.loads(said)["findings"] if one["effect"] != "rod_inertia"]


def _words(one: dict[str, Any]) -> str:
    return " or ".join((one["effect"], *one["confusable_with"]))


def _run(command: str, *arguments: object) -> str:
    line = [program(command), *map(str, arguments)]
    return subprocess.run(line, check=True, capture_output=True, text=True).stdout


if __name__ == "__main__":
    main()
