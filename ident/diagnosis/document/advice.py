"""Commands that a user may run after a diagnosis."""

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import NextMotion
from ident.diagnosis.search.selection import Finding
from ident.dynamics.effects.library import names as built_in
from recordings.next_command import NEXT_MOTION, free_name, free_output


def next_motion(diagnosis: Diagnosis, findings: Sequence[Finding]) -> NextMotion | None:
    """The motion that discriminates the `findings` from their alternatives, or else one to confirm them."""
    split = diagnosis.split
    files = list(dict.fromkeys(str(data.recording.path) for data in split.recordings))
    recording_options = [f"--recording {shlex.quote(file)}" for file in files]
    for finding in findings:
        # No motion discriminates effects that change with time; a vibration is no effect of the library.
        known = {name: diagnosis.library[name] for name in finding.alternatives if name in diagnosis.library}
        alternatives = [name for name, effect in known.items() if effect.axis != "time"]
        if not alternatives or finding.term.effect.axis == "time":
            continue
        name = finding.term.name
        effect_files = [f"--effect-file {effect}.py" for effect in (name, *alternatives) if effect not in built_in()]
        joints = () if finding.term.effect.whole_robot else (f"--joint {joint + 1}" for joint in finding.term.joints)
        pairs = (f"--discriminate {name} {effect}" for effect in alternatives)
        return NextMotion(
            why=f"{name} and {', '.join(alternatives)} cannot be distinguished by these recordings; record another.",
            command=" ".join(
                ("ident design", *pairs, *joints, *recording_options, *effect_files, f"-o {free_name(NEXT_MOTION)}")
            ),
        )
    if not split.other_motion and len(files) == 1:
        return NextMotion(
            why="A second, different motion would show whether the findings also hold for other motions.",
            command=" ".join(("ident design", *recording_options, f"-o {free_name(NEXT_MOTION)}")),
        )
    return None


def fit_command(diagnosis: Diagnosis, path: Path, joints: Sequence[int]) -> str:
    """The command that fits the final model with the learned curves in the effect file `path`."""
    split, terms = diagnosis.split, diagnosis.model.terms
    specified = [
        term.name if term.effect.whole_robot else f"{term.name}:{_joined(joint + 1 for joint in term.joints)}"
        for term in terms
    ]
    user_effects = {term.name for term in terms} - set(built_in())
    files = [str(split.recordings[i].recording.path) for i in split.train_indices]
    test_files = [
        str(data.recording.path) for data, rows in zip(split.recordings, split.test, strict=True) if rows.any()
    ]
    words = ["ident fit", *map(shlex.quote, dict.fromkeys(files))]
    words += [f"--validate {shlex.quote(test_files[0])}"] if split.other_motion else []
    words += [f"--with {term}" for term in (*dict.fromkeys(specified), f"{path.stem}:{_joined(joints)}")]
    words += [
        f"--effect-file {shlex.quote(file)}" for file in (*(f"{name}.py" for name in sorted(user_effects)), str(path))
    ]
    words += map(shlex.quote, map(str, free_output("-o", Path(files[0]).with_suffix(".model.json"))))
    return " ".join(words)


def _joined(joints: Iterable[int]) -> str:
    return ",".join(map(str, joints))
