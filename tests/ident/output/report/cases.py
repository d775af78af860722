"""Recordings and a model with hostile names, for tests of reports."""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from ident.program import program
from recordings.rig import simulated_rig
from tests.ident.conftest import make_recording, write_recording
from tests.running import ran

HOSTILE = "<script>alert('x')</script>&amp;"


run = partial(ran, program)


@dataclass(frozen=True)
class Case:
    folder: Path
    model: Path
    train: Path
    validate: Path


def make_case(folder: Path) -> Case:
    """Two recordings of a rig with a hostile name, and a model fitted to the first."""
    rig = simulated_rig().model_copy(update={"name": HOSTILE})
    paths = [folder / "<b>a.mcap", folder / "b&.mcap"]
    for path, trajectory, cycles in zip(paths, ("fig5a", "fig5b"), (2, 3), strict=True):
        recording = make_recording(
            trajectory, cycles=cycles, rate=250.0, noise=0.02, rig=rig.at_rate(250.0), path=path
        )
        hostile = recording.run.model_copy(update={"trajectory": HOSTILE, "reason": HOSTILE, "software": HOSTILE})
        write_recording(replace(recording, run=hostile))
    model = folder / "<i>a.json"
    run("fit", paths[0], "--method", "ls", "-o", model)
    return Case(folder, model, paths[0], paths[1])
