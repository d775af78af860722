"""The page of constants is the one that the code gives."""

from tests.constants_page import PAGE, page


def test_page_is_up_to_date() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "run `make docs-output`"
