"""Comparison on the simulated rig: how well it follows fig5b without, and with a model as feed-forward."""

from collections.abc import Mapping
from dataclasses import dataclass

from ident.data.following_error import Following, following
from ident.identification.model_file import ModelFile
from ident.output.figures.quality import following_errors
from ident.workbench.figure import Figure, to_dict
from ident.workbench.folder import SUFFIX, Folder
from ident.workbench.programs.running import as_words, printed_by
from recordings.reader import read

MOTION = "fig5b"
WITHOUT, WITH = "without feed-forward", "with the model"


@dataclass(frozen=True, eq=False)
class ComparisonResult:
    """Two runs of the same motion."""

    model: ModelFile
    files: tuple[str, str]
    """Recordings without and with the model's torque."""
    runs: tuple[Following, Following]
    """In the same order."""
    figure: Figure
    """Following error of both over time."""


def compare(folder: Folder, model: ModelFile, model_name: str, machine: Mapping[str, str]) -> ComparisonResult:
    """Record without feed-forward, then with `model`, which is saved as `model_name`.

    machine: `--sim` and `--hidden` of `daq record`.

    Raises:
        BadInput: a recording cannot be made.
    """
    options = as_words({"--traj": MOTION, "--cycles": "2", "--pace": "lockstep", **machine})
    files = []
    for kind, feedforward in (("plain", ()), ("feedforward", ("--feedforward", model_name))):
        file = folder.new_file(folder.free_name(f"{MOTION}-{kind}", SUFFIX), SUFFIX)
        printed_by(folder.root, "daq", "record", *options, *feedforward, "--out", file.name)
        files.append(file)
    plain, fed = map(read, files)
    figure = to_dict(following_errors({WITHOUT: plain, WITH: fed}))
    return ComparisonResult(model, (plain.path.name, fed.path.name), (following(plain), following(fed)), figure)
