"""Run the console blocks of the documentation, which are commands with their output, and renew them.

`make docs-output` runs the commands of all documents and writes their output below them.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

from tests.patience import patient

ROOT = Path(__file__).parent.parent

_BLOCK = re.compile(r"^```console\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
_ANY_LINES = "..."


@dataclass(frozen=True)
class Example:
    """A `$ command` and the output below it; a line `...` stands for any number of lines."""

    command: str
    output: str


@dataclass(frozen=True)
class Session:
    """A folder with `runs` and the sample recordings. A command runs once there, however many documents show it."""

    folder: Path
    outputs: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        (self.folder / "runs").mkdir()
        shutil.copytree(ROOT / "recordings" / "samples", self.folder / "recordings" / "samples")

    def run(self, command: str) -> str:
        """Output of `command`, run now or before."""
        if command not in self.outputs:
            done = subprocess.run(
                ["/bin/sh", "-c", f"PATH={Path(sys.executable).parent}:$PATH; {command}"],
                cwd=self.folder,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                timeout=patient(900),
            )
            assert "Traceback" not in done.stdout, done.stdout
            self.outputs[command] = done.stdout
        return self.outputs[command]


def documents() -> list[Path]:
    """README and the pages of the documentation, in the order in which their commands run."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def examples(document: Path) -> list[Example]:
    """Examples of a Markdown document, in order."""
    return [example for block in _BLOCK.findall(document.read_text(encoding="utf-8")) for example in _split(block)]


def _split(block: str) -> list[Example]:
    parts = [part.partition("\n") for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]]
    return [Example(command.strip(), output) for command, _, output in parts]


def agrees(shown: str, printed: str, tolerance: float = 0.05) -> bool:
    """Whether `printed` agrees with the output in the document.

    Words must be the same and numbers within a relative `tolerance`, because processors round differently. `...`
    stands for any lines.
    """
    pieces = re.split(r"^\.\.\.$\n?", shown, flags=re.MULTILINE)
    pattern = r"[\s\S]*?".join(_words(piece) for piece in pieces)
    match = re.fullmatch(rf"\s*{pattern}\s*", printed)
    if match is None:
        return False
    expected = [float(number) for piece in pieces for number in _NUMBER.findall(piece)]
    actual = [float(number) for number in match.groups()]
    return all(abs(a - b) <= tolerance * max(abs(a), abs(b)) + 2e-4 for a, b in zip(expected, actual, strict=True))


def _words(piece: str) -> str:
    parts = _NUMBER.split(piece)
    escaped = [r"\s+".join(re.escape(word) for word in re.split(r"\s+", part)) for part in parts]
    return rf"({_NUMBER.pattern})".join(escaped)


def renewed(shown: str, printed: str) -> str:
    """Return `printed` as the document shows it: as many lines before and after `...` as there were in `shown`."""
    lines = [line.rstrip() for line in printed.rstrip().splitlines()]
    kept = shown.rstrip().splitlines()
    if _ANY_LINES in kept:
        before = kept.index(_ANY_LINES)
        after = len(kept) - before - 1
        lines = [*lines[:before], _ANY_LINES, *lines[len(lines) - after :]]
    return "".join(f"{line}\n" for line in lines)


def renew(document: Path, session: Session) -> None:
    """Run the examples of `document` and replace their outputs."""

    def rerun(match: re.Match[str]) -> str:
        parts = [
            f"$ {shown.command}\n{renewed(shown.output, session.run(shown.command))}" for shown in _split(match[1])
        ]
        return "```console\n" + "".join(parts) + "```"

    text = document.read_text(encoding="utf-8")
    document.write_text(_BLOCK.sub(rerun, text), encoding="utf-8")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        session = Session(Path(folder))
        for document in documents():
            renew(document, session)
