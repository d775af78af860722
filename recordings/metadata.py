"""The metadata records `rig` and `run` of a recording, shared by all writers."""

import json
from importlib.metadata import version

from recordings import schemas
from recordings.recording import Run
from recordings.rig import Rig


def software() -> str:
    """Name and version of this program, as recordings say by what they were written."""
    return f"delta-workbench {version('delta-workbench')}"


def rig_record(rig: Rig) -> dict[str, str]:
    """Contents of the metadata record `rig`."""
    return {"layout": schemas.LAYOUT, "json": clean(rig.model_dump_json())}


def run_record(run: Run) -> dict[str, str]:
    """Contents of the metadata record `run`."""
    values = run.model_dump(mode="json", exclude_none=True)
    return {name: clean(value) if isinstance(value, str) else json.dumps(value) for name, value in values.items()}


def clean(text: str) -> str:
    """Replace lone surrogates, which file names may contain and UTF-8 cannot encode."""
    return text.encode("utf-8", "replace").decode()
