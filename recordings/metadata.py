"""The metadata records `rig` and `run`, as every writer puts them into a recording."""

import json

from recordings import schemas
from recordings.recording import Run
from recordings.rig import Rig


def rig_record(rig: Rig) -> dict[str, str]:
    """The metadata record `rig`."""
    return {"layout": schemas.LAYOUT, "json": clean(rig.model_dump_json())}


def run_record(run: Run) -> dict[str, str]:
    """The metadata record `run`."""
    values = run.model_dump(mode="json", exclude_none=True)
    return {name: clean(value) if isinstance(value, str) else json.dumps(value) for name, value in values.items()}


def clean(text: str) -> str:
    """Without lone surrogates, as they come from file names, which UTF-8 cannot hold."""
    return text.encode("utf-8", "replace").decode()
