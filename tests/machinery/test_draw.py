"""A draw of slow tests: every module has its turn, and every process draws the same."""

from pathlib import Path

import pytest

from tests.machinery.conftest import Planted
from tests.machinery.draw import bucket, drawn, parsed

HERE = Path(__file__).parents[2]
MODULES = [str(path.relative_to(HERE)) for path in HERE.glob("tests/**/test_*.py")]
COUNT = 5
DIGESTS = {bucket(digest, COUNT): digest for digest in map(str, range(60))}
"""A digest for each bucket."""


def test_the_shares_are_disjoint_and_cover_all_modules() -> None:
    shares = [set(filter(drawn(f"1/{COUNT}", digest), MODULES)) for digest in DIGESTS.values()]
    assert len(shares) == COUNT
    assert all(shares)
    assert sorted(name for share in shares for name in share) == sorted(MODULES)
    assert all(map(drawn("5/5", "any"), MODULES))
    two = set(filter(drawn("2/5", DIGESTS[4]), MODULES))
    assert two == set(filter(drawn("1/5", DIGESTS[4]), MODULES)) | set(filter(drawn("1/5", DIGESTS[0]), MODULES))


@pytest.mark.parametrize("share", ["", "5", "0/5", "6/5", "1/0", "1/5/2", "a/b", "-1/5"])
def test_what_is_no_share_is_refused(share: str) -> None:
    with pytest.raises(pytest.UsageError, match="expected a share such as 1/5"):
        parsed(share)


@pytest.mark.slow
def test_the_draw_is_the_same_side_by_side_and_keeps_what_is_essential(planted: Planted) -> None:
    for number in range(8):
        planted.write(f"test_{number}", "def test_it(): pass\n")
    essential = "import pytest\n@pytest.mark.essential\ndef test_essential(): pass\ndef test_other(): pass\n"
    names = {f"test_{name}" for name in "abcdefgh"}
    for name in names:
        planted.write(name, essential)
    one, two = planted.run("--share", "1/5", "--draw", "x"), planted.run("--share", "1/5", "--draw", "x", "-n", "2")
    assert one.passed == two.passed
    assert {f"{name}.py::test_essential" for name in names} < one.passed
    assert len(one.passed) < 24
