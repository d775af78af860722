"""Commands that a user may run after a diagnosis."""

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import FindingEntry, NextMotion
from ident.dynamics.effects.library import names as built_in
from recordings.command_line import repeated
from recordings.next_command import design, free_output


def next_motion(diagnosis: Diagnosis, findings: Sequence[FindingEntry]) -> NextMotion | None:
    """The motion that discriminates the `findings` from their alternatives, or else one to confirm them."""
    split, library = diagnosis.split, diagnosis.library
    files = list(dict.fromkeys(data.recording.path for data in split.recordings))
    for finding in findings:
        # No motion discriminates effects that change with time; a vibration is no effect of the library.
        name = finding.effect
        alternatives = [each for each in finding.confusable_with if each in library and library[each].axis != "time"]
        if not alternatives or library[name].axis == "time":
            continue
        options = [
            *(word for other in alternatives for word in ("--discriminate", name, other)),
            *repeated("--joint", () if library[name].whole_robot else finding.joints),
            *repeated("--effect-file", (f"{each}.py" for each in (name, *alternatives) if each not in built_in())),
        ]
        return NextMotion(
            why=f"These recordings cannot distinguish {name} from {' or '.join(alternatives)}; another motion can.",
            command=design(files, *options),
        )
    if split.other_motion or len(files) > 1:
        return None
    why = "A second, different motion would show whether the findings also hold for other motions."
    return NextMotion(why=why, command=design(files))


def fit_command(diagnosis: Diagnosis, path: Path, joints: Sequence[int]) -> str:
    """The command that fits the last model with the learned curves in the effect file `path`.

    joints: those with a curve, from 1.
    """
    split, terms = diagnosis.split, diagnosis.model.terms
    specified = [
        term.name if term.effect.whole_robot else _specified(term.name, (joint + 1 for joint in term.joints))
        for term in terms
    ]
    user_effects = sorted({term.name for term in terms} - set(built_in()))
    files = dict.fromkeys(str(split.recordings[i].recording.path) for i in split.train_indices)
    held_out = [
        str(data.recording.path) for data, rows in zip(split.recordings, split.test, strict=True) if rows.any()
    ]
    words = [
        *("ident", "fit", *files),
        *repeated("--validate", held_out[:1] if split.other_motion else ()),
        *repeated("--with", (*dict.fromkeys(specified), _specified(path.stem, joints))),
        *repeated("--effect-file", (*(f"{name}.py" for name in user_effects), path)),
        *map(str, free_output("-o", Path(next(iter(files))).with_suffix(".model.json"))),
    ]
    return shlex.join(words)


def _specified(effect: str, joints: Iterable[int]) -> str:
    return f"{effect}:{','.join(map(str, joints))}"
