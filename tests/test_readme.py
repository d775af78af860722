"""README agrees with the programs: its commands print the shown output; named commands and files exist."""

import re
from pathlib import Path

import pytest

from tests.readme import ROOT, agrees, examples, prepared, printed

README = ROOT / "README.md"


@pytest.mark.slow
def test_commands_print_the_shown_output(tmp_path: Path) -> None:
    folder = prepared(tmp_path)
    shown = examples(README)
    assert len(shown) >= 4
    for example in shown:
        outputs = printed(example.command, folder)
        assert agrees(example.output, outputs), f"$ {example.command}\n{outputs}"


def test_every_command_is_in_the_readme() -> None:
    text = README.read_text(encoding="utf-8")
    for program in ("daq", "ident"):
        for file in (ROOT / program / "commands").glob("[a-z]*.py"):
            command = f"{program} {file.stem.rstrip('_').replace('_', '-')}"
            assert command in text, f"README says nothing of `{command}`"


def test_every_named_make_target_and_file_exists() -> None:
    text = README.read_text(encoding="utf-8")
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"`make ([a-z-]+)`", text):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), f"make {target}"
    for block in re.findall(r"^```sh\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        for target in re.findall(r"^make ([a-z-]+)", block, re.MULTILINE):
            assert re.search(rf"^{target}:", makefile, re.MULTILINE), f"make {target}"
    for link in re.findall(r"\]\(([^)#:]+)\)", text):
        assert (ROOT / link).exists(), link


@pytest.mark.parametrize(
    ("shown", "printed", "expected"),
    [
        ("cycles 120\n", "cycles   121\n", True),
        ("cycles 120\n", "cycles 140\n", False),
        ("a 1\n...\nz\n", "a 1\nb\nc\nz\n", True),
        ("a 1\n...\nz\n", "a 1\nb\nc\n", False),
        ("error: -0.35 V\n", "error: 0.35 V\n", False),
        ("x\n", "x y\n", False),
    ],
)
def test_outputs_agree_up_to_the_tolerance_of_numbers(shown: str, printed: str, expected: bool) -> None:
    assert agrees(shown, printed) is expected
