"""A rate is counted from the first results on, by when they were finished; the table follows from rates."""

from pathlib import Path

import pytest

from benchmarks.fleet import throughput
from recordings.errors import BadInput


def test_folder_with_too_few_recordings_is_left_as_it_is(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="100 recordings expected, 0 found"):
        throughput._recordings(tmp_path, 100)
    assert not list(tmp_path.iterdir())
