"""What benchmarks measure with."""

import pytest

from benchmarks import programs


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ([2.0, 1.0, 3.0], "1.000 (median of 3 pairs; single pairs 0.500 to 1.500)"),
        (
            [1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 7.0],
            "1.500 (median of 7 pairs, 95 % interval 0.500 to 3.500; single pairs 0.500 to 3.500)",
        ),
    ],
)
def test_ratio_is_of_pairs_with_their_spread(values: list[float], text: str) -> None:
    assert programs.ratio(values, [2.0] * len(values)) == text


def test_failure_of_a_program_ends_with_what_it_says() -> None:
    with pytest.raises(SystemExit, match=r"(?s)ident fit none.mcap.*does not exist"):
        programs.call("ident", "fit", "none.mcap")
