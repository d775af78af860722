"""How benchmarks run the programs."""

import pytest

from benchmarks import programs


def test_failure_of_a_program_ends_with_what_it_says() -> None:
    with pytest.raises(SystemExit, match=r"(?s)ident fit none.mcap.*does not exist"):
        programs.call("ident", "fit", "none.mcap")
