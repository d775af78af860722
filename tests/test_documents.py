"""The documents agree with the programs: commands print the shown output; named commands, files and keys exist."""

import re
import tomllib
from pathlib import Path

import pytest
from pydantic import BaseModel

from benchmarks.real.data_set import Manifest
from drivers.simulated.config import SimConfig
from ident.diagnosis.document.document import Document
from ident.identification.model_file import ModelFile
from recordings.rig import Rig
from tests.documents import ROOT, Session, agrees, documents, examples, renewed

README = ROOT / "README.md"
CONTRIBUTING = ROOT / "CONTRIBUTING.md"


@pytest.mark.slow
@pytest.mark.parametrize(
    "which", [pytest.param([README], marks=pytest.mark.essential, id="README"), pytest.param(documents(), id="all")]
)
def test_commands_print_the_shown_output(which: list[Path], tmp_path: Path) -> None:
    session = Session(tmp_path)
    shown = [(document.name, example) for document in which for example in examples(document)]
    assert "README.md" in {name for name, _ in shown}
    for name, example in shown:
        printed = session.run(example.command)
        assert agrees(example.output, printed), f"{name}: $ {example.command}\n{printed}"


def test_readme_fits_on_three_screens() -> None:
    assert len(README.read_text(encoding="utf-8").split()) <= 1000


def test_every_command_is_in_the_documents() -> None:
    text = "\n".join(document.read_text(encoding="utf-8") for document in documents())
    for program in ("daq", "ident"):
        for file in (ROOT / program / "commands").glob("[a-z]*.py"):
            command = f"{program} {file.stem.rstrip('_').replace('_', '-')}"
            assert command in text, f"the documents say nothing of `{command}`"


@pytest.mark.parametrize("document", [*documents(), CONTRIBUTING], ids=lambda path: path.name)
def test_every_named_make_target_and_file_exists(document: Path) -> None:
    text = document.read_text(encoding="utf-8")
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    commands = "\n".join(re.findall(r"^```sh\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))
    for target in [*re.findall(r"`make ([a-z-]+)", text), *re.findall(r"^make ([a-z-]+)", commands, re.MULTILINE)]:
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), f"make {target}"
    for link in re.findall(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)", text):
        assert (document.parent / link).exists(), link
    for path in re.findall(
        r"`((?:daq|docs|drivers|ident|recordings|tests|trajectories|delta_web)/[a-z0-9_/-]+\.py)", text
    ):
        assert (ROOT / path).exists(), path


def test_pre_commit_runs_what_lint_runs() -> None:
    recipe = re.search(r"^lint:.*\n((?:\t.*\n)+)", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert recipe
    commands = [line.replace("$(BIN)", ".venv/bin") for line in recipe[1].split("\t")[1:]]
    hooks = re.findall(r"entry: (.*)}", (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8"))
    assert [command.strip().removesuffix(" .") for command in commands] == hooks


def test_configuration_files_in_the_documents_are_valid() -> None:
    blocks = [
        block
        for document in documents()
        for block in re.findall(
            r"^```toml\n(.*?)^```$", document.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
        )
    ]
    assert len(blocks) >= 3
    for block in blocks:
        kinds: dict[str, type[BaseModel]] = {"# sim.toml": SimConfig, "# data set": Manifest}
        kind = next((kinds[start] for start in kinds if block.startswith(start)), Rig)
        kind.model_validate(tomllib.loads(block), strict=False)


@pytest.mark.parametrize(("page", "document"), [("model-file", ModelFile), ("diagnose-json", Document)])
def test_every_key_of_a_document_is_explained(page: str, document: type[BaseModel]) -> None:
    text = (ROOT / "docs" / "reference" / f"{page}.md").read_text(encoding="utf-8")
    explained = "".join(re.findall(r"^\| (`.*?) \|", text, re.MULTILINE))
    for name, field in document.model_fields.items():
        assert f"`{field.alias or name}`" in explained, name


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


@pytest.mark.parametrize(
    ("shown", "printed", "expected"),
    [
        ("old\n", "a  \nb\n\n", "a\nb\n"),
        ("old\n...\n", "a\nb\nc\n", "a\n...\n"),
        ("...\nold\nold\n", "a\nb\nc\n", "...\nb\nc\n"),
        ("old\n...\nold\n", "a\nb\nc\n", "a\n...\nc\n"),
    ],
)
def test_renewed_output_is_shortened_where_the_document_shortens_it(shown: str, printed: str, expected: str) -> None:
    assert renewed(shown, printed) == expected
