"""Does the motion of `ident design --discriminate` settle what one recording could not? As a user would do it.

An effect is hidden in the simulated rig, fig5a is recorded and diagnosed. Where the finding could be something else,
the motion that the diagnosis recommends is designed and recorded, and both recordings are diagnosed together: with
parts of themselves held out, and once more with another motion, fig5b, that tells the explanations apart no better.
"""

import json
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from benchmarks.demo import program

HIDDEN = (
    ("arm_mass_mismatch", 0.01, [2]),
    ("torque_gain_mismatch", 0.01, [2]),
    ("torque_offset", 0.01, [2]),
    ("encoder_zero_offset", 0.01, [2]),
    ("backlash", 0.01, [2]),
    ("arm_com_offset", 0.01, [2]),
    ("arm_mass_mismatch", 0.03, [2]),
    ("torque_gain_mismatch", 0.01, [3]),
    ("arm_com_offset", 0.01, [1]),
)
"""Effects, their sizes over the torque, and joints: what one recording of fig5a leaves together with others, of all
that was hidden on joint 2 at 1 % and 3 %; and two of them on other joints."""


def main() -> None:
    """Tell one story for each hidden effect, or for each of those that the command line names."""
    for effect, size, joints in HIDDEN:
        if not sys.argv[1:] or effect in sys.argv[1:]:
            print(f"discriminate: {effect} {size:.0%}, joint {', '.join(map(str, joints))}", flush=True)
            with tempfile.TemporaryDirectory() as folder:
                _story(Path(folder), effect, size, joints)


def _story(folder: Path, effect: str, size: float, joints: list[int]) -> None:
    sim = folder / "sim.toml"
    sim.write_text(f'[[effects]]\nname = "{effect}"\nsize = {size}\njoints = {joints}\n', encoding="utf-8")
    first = _recorded("fig5a", sim, folder / "first.mcap")
    before = _diagnosed([first])
    _say("fig5a", _words(before))
    if not any(finding["confusable_with"] for finding in _news(before)):
        return
    motion = folder / "next.toml"
    command = shlex.split(before["next_motion"]["command"])
    try:
        designed = json.loads(_run(*command[:-1], motion, "--json"))
    except subprocess.CalledProcessError as failed:
        _say("design", failed.stderr.strip())
        return
    _say("separation", f"{_separation(designed['before'])} on fig5a")
    _say("", f"{_separation(designed['after'])} with {designed['trajectory']}, {_use(designed['after'])}")
    both = [first, _recorded(motion, sim, folder / "second.mcap")]
    other = ["--validate", _recorded("fig5b", sim, folder / "other.mcap")]
    for what, after in (("both", _diagnosed(both)), ("and fig5b", _diagnosed([*both, *other]))):
        names = [(finding["effect"], finding["confusable_with"]) for finding in _news(after)]
        _say(what, f"{_words(after)}: {'right' if names == [(effect, [])] else 'NOT RIGHT'}")


def _say(what: str, words: str) -> None:
    print(f"  {what:<11} {words}", flush=True)


def _separation(quality: dict[str, Any]) -> str:
    return ", ".join(f"{effect} {share:.1%}" for effect, share in quality["told_apart"].items())


def _use(quality: dict[str, Any]) -> str:
    limit, share = max(quality["limits"].items(), key=lambda item: item[1])
    return f"{share:.0%} of {limit}"


def _recorded(motion: object, sim: Path, out: Path) -> Path:
    _run("daq", "record", "--traj", motion, "--sim", sim, "--out", out)
    return out


def _diagnosed(arguments: Sequence[object]) -> dict[str, Any]:
    document: dict[str, Any] = json.loads(_run("ident", "diagnose", *arguments, "--json", "--force"))
    return document


def _news(document: dict[str, Any]) -> list[dict[str, Any]]:
    """What is found beside the forearms' inertia."""
    return [finding for finding in document["findings"] if finding["effect"] != "rod_inertia"]


def _words(document: dict[str, Any]) -> str:
    names = [" or ".join((finding["effect"], *finding["confusable_with"])) for finding in _news(document)]
    return ", ".join(names) or document["verdict"]


def _run(command: str, *arguments: object) -> str:
    line = [program(command), *map(str, arguments)]
    return subprocess.run(line, check=True, capture_output=True, text=True).stdout


if __name__ == "__main__":
    main()
