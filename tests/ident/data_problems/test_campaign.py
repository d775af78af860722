"""A foreign delta robot that measures its efforts: mistakes are named, and what is healed has the clean verdict."""

from pathlib import Path

import pytest

from tests.ident.data_problems import campaign
from tests.ident.data_problems.test_mistakes import MISTAKES

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def clean(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[Path], campaign.Conclusion]:
    """Two recordings, and what a diagnosis says of them."""
    files = campaign.clean(tmp_path_factory.mktemp("clean"), "heavy")
    return files, campaign.diagnosed(files).conclusion


@pytest.mark.parametrize("name", MISTAKES)
def test_mistake_is_named_and_its_remedy_leads_to_the_clean_verdict(
    name: str, clean: tuple[list[Path], campaign.Conclusion], tmp_path: Path
) -> None:
    found = campaign.fault(MISTAKES[name], *clean, tmp_path)
    assert found == ""
