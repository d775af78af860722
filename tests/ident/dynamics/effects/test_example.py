"""The worked example of docs/how-to/your-own-effect.md."""

from pathlib import Path

from click.testing import CliRunner

from ident.dynamics.effects.library import library
from ident.program import program
from recordings.errors import BadInput

EXAMPLE = Path(__file__).parents[4] / "docs" / "examples" / "tight_spot.py"


def test_the_example_is_short_and_an_effect() -> None:
    assert len(EXAMPLE.read_text().splitlines()) < 40
    assert "tight_spot" in library([EXAMPLE])


def test_the_example_is_listed_and_explained() -> None:
    listed = CliRunner().invoke(program, ["effects", "--effect-file", str(EXAMPLE), "--json"])
    assert '"tight_spot"' in listed.stdout
    explained = CliRunner().invoke(program, ["effects", "tight_spot", "--effect-file", str(EXAMPLE)])
    assert "Around one angle the joint rubs harder." in explained.stdout


def test_an_unknown_effect_is_refused() -> None:
    refused = CliRunner().invoke(program, ["effects", "stribek"])
    assert isinstance(refused.exception, BadInput)
    assert "did you mean stribeck?" in str(refused.exception)
