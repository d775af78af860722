import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from ident.cli import program
from ident.paper.methods import PAPER
from recordings.errors import BadInput


def table2(*arguments: object) -> Result:
    return CliRunner().invoke(program, ["table2", *map(str, arguments)], catch_exceptions=True)


def test_the_samples_show_the_papers_order_beside_its_values(tmp_path: Path) -> None:
    result = table2("--plots", tmp_path / "plots")
    assert result.exit_code == 0, result.output
    printed = " ".join(result.stdout.split())
    for values in PAPER.values():
        for value in values:
            assert f"{value:.4f}" in printed
    for role in ("identification", "validation"):
        assert f"The paper's order holds on {role} data: PSO is above RLS, DLS and SVD on every joint." in printed
    assert "Not comparable: the values" in printed
    assert "SIMULATED" in printed
    figures = sorted(path.name for path in (tmp_path / "plots").iterdir())
    assert figures == sorted(f"figure_{number}.png" for number in (3, 6, 7, 8, 9, 10))


def test_json_is_one_document_and_nothing_else(tmp_path: Path) -> None:
    document = json.loads(table2("--json", "--preprocess", "parallel", "--plots", tmp_path / "plots").stdout)
    assert document["pso_above_baselines"] == {"identification": True, "validation": True}
    assert document["methods"]["svd"]["diagnostics"]["rank"] == 13
    assert document["methods"]["pso"]["excess"] < 1e-6
    assert document["methods"]["ls"]["excess"] is None


def test_existing_pictures_are_kept_unless_forced(tmp_path: Path) -> None:
    refused = table2("--plots", tmp_path)
    assert isinstance(refused.exception, BadInput)
    assert "--force" in str(refused.exception)


@pytest.mark.parametrize("files", [["a.mcap"], ["a.mcap", "b.mcap", "c.mcap"]])
def test_two_recordings_are_needed(files: list[str]) -> None:
    refused = table2(*files)
    assert isinstance(refused.exception, BadInput)
    assert f"{len(files)} found" in str(refused.exception)
