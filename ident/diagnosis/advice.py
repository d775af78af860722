"""Commands that a user may run after a diagnosis."""

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document import NextMotion
from ident.diagnosis.steps import Finding
from ident.dynamics.effects.library import names as built_in


def next_motion(found: Diagnosis, news: Sequence[Finding]) -> NextMotion | None:
    """Recommend a motion that discriminates the `findings` from their alternatives, or a second motion to confirm
    them.
    """
    material = found.split
    files = list(dict.fromkeys(str(data.recording.path) for data in material.datasets))
    beside = [f"--recording {shlex.quote(file)}" for file in files]
    for one in news:
        # What changes with time no motion tells from anything.
        others = [name for name in one.alternatives if found.library[name].axis != "time"]
        if not others or one.term.effect.axis == "time":
            continue
        name = one.term.name
        own_files = [f"--effect-file {other}.py" for other in (name, *others) if other not in built_in()]
        joints = () if one.term.effect.whole_robot else (f"--joint {joint + 1}" for joint in one.term.joints)
        pairs = (f"--discriminate {name} {other}" for other in others)
        return NextMotion(
            why=f"{name} and {', '.join(others)} cannot be told apart on these recordings; another motion can.",
            command=" ".join(("ident design", *pairs, *joints, *beside, *own_files, f"-o {_free_file_name()}")),
        )
    if not material.other_motion and len(files) == 1:
        return NextMotion(
            why="A second, different motion would show whether the findings hold beyond this one.",
            command=" ".join(("ident design", *beside, f"-o {_free_file_name()}")),
        )
    return None


def fit_command(found: Diagnosis, path: Path, joints: Sequence[int]) -> str:
    """The command that fits the final model of `diagnosis` together with the learned curves in the effect file
    `path`.
    """
    material, terms = found.split, found.selection.steps[-1].model.terms
    specified = [
        term.name if term.effect.whole_robot else f"{term.name}:{_joined(joint + 1 for joint in term.joints)}"
        for term in terms
    ]
    own = {term.name for term in terms} - set(built_in())
    files = [str(material.datasets[i].recording.path) for i in material.train_indices]
    held = [
        str(data.recording.path) for data, rows in zip(material.datasets, material.test, strict=True) if rows.any()
    ]
    parts = ["ident fit", *map(shlex.quote, dict.fromkeys(files))]
    parts += [f"--validate {shlex.quote(held[0])}"] if material.other_motion else []
    parts += [f"--with {one}" for one in (*dict.fromkeys(specified), f"{path.stem}:{_joined(joints)}")]
    parts += [f"--effect-file {shlex.quote(one)}" for one in (*(f"{name}.py" for name in sorted(own)), str(path))]
    return " ".join(parts)


def _joined(joints: Iterable[int]) -> str:
    return ",".join(map(str, joints))


def _free_file_name() -> str:
    """A file name for the next motion that does not exist yet."""
    numbered = (Path(f"next{number}.toml") for number in ("", *range(2, 100)))
    return str(next((path for path in numbered if not path.exists()), "next.toml"))
