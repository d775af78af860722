"""The true properties of a simulated recording, in a separate file that is not read by accident."""

import base64
import hashlib
import json
import math
import zlib
from pathlib import Path
from typing import Any

from drivers.simulated.config import SimConfig
from drivers.simulated.effect import HiddenEffect, build
from drivers.simulated.sizing import EffectSizer
from recordings.errors import BadInput
from recordings.limits import LARGEST_TEXT, json_object, parsed
from recordings.rig import Rig

_NOTE = "sealed: what was hidden in the simulated robot of the recording beside this file; open it last"


def sealed_path(recording: Path) -> Path:
    """Path of the sealed file of a recording."""
    return recording.with_suffix(".sealed.json")


def truth(rig: Rig, config: SimConfig, seed: int | None, sizer: EffectSizer | None = None) -> dict[str, Any]:
    """True properties of the machine: effects (SI) with their sizes along fig5a, seed of --hidden, plant.

    Each effect has the variables it depends on, whether it is in the list of effects, and `at` [s] in an event.
    `sizer`: an existing one for this machine.
    """
    sizer = sizer or EffectSizer(rig, config)
    return {
        "schema": 1,
        "seed": seed,
        "effects": [
            *(_describe(build(spec), sizer) for spec in config.effects),
            *(_describe(build(effect), sizer) | {"at": at} for at, effect in config.effects_that_begin),
        ],
        "plant": config.model_dump(mode="json", exclude={"effects", "events"}),
    }


def _describe(effect: HiddenEffect, sizer: EffectSizer) -> dict[str, Any]:
    size = sizer.size(effect)
    if not math.isfinite(size):
        raise BadInput(f"effect {effect.name()} prevents the robot from following fig5a; choose a smaller one")
    return {
        **effect.spec().model_dump(mode="json", exclude={"size"}),
        "size": size,
        "in_library": effect.in_library(),
        "depends_on": list(effect.depends_on()),
    }


def seal(path: Path, content: dict[str, Any]) -> None:
    """Write `content`, readable only through `unseal`.

    Raises:
        BadInput: the file exists.
    """
    packed = zlib.compress(json.dumps(content, sort_keys=True, allow_nan=False).encode())
    wrapper = {
        "schema": 1,
        "note": _NOTE,
        "sha256": hashlib.sha256(packed).hexdigest(),
        "sealed": base64.b64encode(packed).decode(),
    }
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(json.dumps(wrapper, indent=1) + "\n")
    except FileExistsError:
        raise BadInput(f"a new name expected, {path} exists; give another one, or remove it") from None


def unseal(path: Path) -> dict[str, Any]:
    """Read a file written by `seal`.

    Raises:
        BadInput: the file is missing, is not a sealed file, or was changed.
    """
    wrapper = json_object(path, "sealed file")
    try:
        packed = base64.b64decode(wrapper["sealed"], validate=True)
        changed = hashlib.sha256(packed).hexdigest() != wrapper["sha256"]
        text = "" if changed else zlib.decompressobj().decompress(packed, LARGEST_TEXT).decode()
    except (zlib.error, ValueError, KeyError, TypeError):
        raise BadInput(
            f"{path} is not a sealed file; a file that `daq record` wrote beside a recording expected"
        ) from None
    if changed:
        raise BadInput(f"{path} was changed after it was sealed; its checksum does not fit")
    return parsed(json.loads, text, f"sealed file {path}", "JSON")
