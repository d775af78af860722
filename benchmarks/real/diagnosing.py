"""Import and diagnose one data set, and judge what was claimed about it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from benchmarks.real.data_set import Claim, Manifest, Part
from recordings.csv_table import read_table
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig

Judgement = Literal["right", "or", "missed", "wrong", "unknown"]
"""or: named beside another effect that the data cannot tell from it. unknown: nobody knows whether it is right."""
_QUARTER = 0.25
"""Length of the stretches of which every fourth validates [s]."""
_BEGIN = 0.6
"""Share of a recording that trains where the rest of it validates."""
_MEASURED = ("effort", "current", "voltage")


@dataclass(frozen=True)
class DiagnosedSet:
    """What was said about one data set."""

    manifest: Manifest
    document: dict[str, Any] | None
    """Of `ident diagnose`; None if it could not be read."""
    problem: str = ""
    diagnosis: Any = None
    """With the models behind the document."""

    @property
    def claims(self) -> list[tuple[str, Judgement]]:
        """Everything that is known, and everything that was found, with its judgement."""
        if self.document is None:
            return []
        known = [(_text(claim), _judge(claim, self.document)) for claim in self.manifest.claims]
        names = {claim.effect for claim in self.manifest.claims}
        others = [entry["effect"] for entry in self.document["findings"] if entry["effect"] not in names]
        return [*known, *((f"{name} (found)", "unknown") for name in others)]

    @property
    def plain(self) -> Floats | None:
        """(dof,) held-out error of plain regression, at the same band and rows; None of single axes."""
        if self.diagnosis is None or not self.manifest.urdf:
            return None
        from benchmarks.real.plain_regression import PlainRegression, rms

        split = self.diagnosis.split
        train = [split.recordings[index] for index in split.train_indices]
        rig = train[0].recording.rig
        plain = PlainRegression(rig.urdf, rig.joints, train)
        held_out = zip(split.recordings, split.test, strict=True)
        residuals = [np.where(rows, plain.residual(each), np.nan) for each, rows in held_out if rows.any()]
        return rms(np.concatenate(residuals))


def diagnose(manifest: Manifest, folder: Path, scratch: Path) -> DiagnosedSet:
    """Diagnose the data set of `manifest` in `folder`.

    Raises:
        BadInput: a file is missing, or cannot be read.
    """
    import ident

    train, validate = _imported(manifest, folder, scratch)
    result = ident.diagnose(train, validate=validate)
    return DiagnosedSet(manifest, result.as_json(), diagnosis=result.diagnosis)


def _imported(manifest: Manifest, folder: Path, scratch: Path) -> tuple[list[Path], list[Path]]:
    """Import the data set of `manifest` in `folder` to `scratch`: recordings for training, and for validation.

    Raises:
        BadInput: a file is missing, or cannot be read.
    """
    train: list[Path] = []
    validate: list[Path] = []
    for part in manifest.parts:
        table = read_table(folder / part.path)
        missing = [column.name for column in manifest.columns.values() if column.name not in table.columns]
        if missing:
            raise BadInput(
                f"{folder / part.path}: columns {', '.join(missing)} expected, none found; see {manifest.get}"
            )
        columns = {name: table.columns[column.name] * column.factor for name, column in manifest.columns.items()}
        for use, kept in _uses(part, columns["time"]):
            out = scratch / f"{manifest.name}-{len(train)}-{len(validate)}"
            recording = _record(_description(manifest, folder), columns, kept, out)
            (train if use == "train" else validate).append(recording)
    return train, validate


def _uses(part: Part, time: Floats) -> list[tuple[str, Any]]:
    """Each use of a file with the samples (n,) whose measured torque it may see."""
    elapsed = time - time[0]
    held_out = {"both": np.floor(elapsed / _QUARTER) % 4 == 3, "begin": elapsed > _BEGIN * elapsed[-1]}.get(part.use)
    if held_out is None:
        return [(part.use, np.ones(len(time), bool))]
    return [("train", ~held_out), ("validate", held_out)]


def _description(manifest: Manifest, folder: Path) -> Any:
    """What the import is told of the machine."""
    from recordings.importing import Description

    if manifest.urdf:
        urdf = (folder / manifest.urdf).read_text(encoding="utf-8")
        return Description(rig=Rig(name=manifest.name, mechanism="urdf", urdf=urdf, joints=manifest.joints))
    types, torque, gravity = manifest.joint_types, manifest.torque, manifest.gravity
    return Description(mechanism="axes", joints=types, torque=torque, gravity=gravity)


def _record(description: Any, columns: dict[str, Floats], kept: Any, out: Path) -> Path:
    """Import the columns, with gaps in what was measured where it is not `kept`."""
    from recordings.importing import import_data

    seen = {
        name: np.where(kept, values, np.nan) if name.startswith(_MEASURED) else values
        for name, values in columns.items()
    }
    table, recording = out.with_suffix(".csv"), out.with_suffix(".mcap")
    np.savetxt(table, np.stack(list(seen.values()), axis=1), "%.9g", ",", header=",".join(seen), comments="")
    import_data(table, recording, description)
    return recording


def _judge(claim: Claim, document: dict[str, Any]) -> Judgement:
    """Judge one claim by the findings of a `document`, or by its verdict."""
    if claim.verdict:
        return "right" if document["verdict"] == claim.verdict else "missed"
    for entry in document["findings"]:
        if claim.effect not in (entry["effect"], *entry["confusable_with"]) or not _has_order(claim, document):
            continue
        if not claim.present:
            return "or" if entry["confusable_with"] else "wrong"
        return "or" if entry["confusable_with"] else "right"
    return "missed" if claim.present else "right"


def _has_order(claim: Claim, document: dict[str, Any]) -> bool:
    if claim.order is None:
        return True
    parameters = document["steps"][-1]["parameters"]
    orders = [entry["value"] for name, entry in parameters.items() if name.split(".")[-1] == "N"]
    return any(abs(order / claim.order - 1) < claim.tolerance for order in orders)


def _text(claim: Claim) -> str:
    if claim.verdict:
        return f"verdict {claim.verdict}"
    order = f" of {claim.order:g} per turn" if claim.order else ""
    return f"{'' if claim.present else 'no '}{claim.effect}{order}"
