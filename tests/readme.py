"""Read and refresh the console blocks of a document, which are commands with their output.

`make readme` runs the commands of README.md and writes their output into it.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent

_BLOCK = re.compile(r"^```console\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


@dataclass(frozen=True)
class Example:
    """A `$ command` and the output below it; a line `...` stands for any number of lines."""

    command: str
    output: str


def prepared(folder: Path) -> Path:
    """Copy the files that the commands of the README need into `folder`."""
    shutil.copytree(ROOT / "recordings" / "samples", folder / "recordings" / "samples")
    return folder


def printed(command: str, folder: Path) -> str:
    """Output of a command of the README in `folder`."""
    done = subprocess.run(
        ["/bin/sh", "-c", f"PATH={Path(sys.executable).parent}:$PATH; {command}"],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=900,
    )
    return done.stdout


def examples(document: Path) -> list[Example]:
    """Examples of a Markdown document, in order."""
    printed = []
    for block in _BLOCK.findall(document.read_text(encoding="utf-8")):
        for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            command, _, output = part.partition("\n")
            printed.append(Example(command.strip(), output))
    return printed


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


def refresh(document: Path) -> None:
    """Run the examples and replace their outputs; blocks with `...` stay unchanged."""
    with tempfile.TemporaryDirectory() as name:
        folder = prepared(Path(name))

        def rerun(match: re.Match[str]) -> str:
            block = match.group(1)
            outputs = []
            for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
                command = part.partition("\n")[0].strip()
                lines = [line.rstrip() for line in printed(command, folder).rstrip().splitlines()]
                outputs.append("\n".join([f"$ {command}", *lines]))
            return match.group(0) if "\n...\n" in block else "```console\n" + "\n".join(outputs) + "\n```"

        document.write_text(_BLOCK.sub(rerun, document.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    refresh(ROOT / "README.md")
