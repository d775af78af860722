"""Patience is a number that the environment may give."""

import pytest

from drivers.patience import VARIABLE, factor
from recordings.errors import BadInput


@pytest.mark.parametrize(("text", "number"), [(None, 1.0), ("", 1.0), ("7.6", 7.6)])
def test_patience_is_what_the_environment_says(
    monkeypatch: pytest.MonkeyPatch, text: str | None, number: float
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    if text is not None:
        monkeypatch.setenv(VARIABLE, text)
    assert factor() == number


@pytest.mark.parametrize("text", ["abc", "0", "-1", "nan", "inf", "1e9"])
def test_what_is_no_patience_is_refused(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setenv(VARIABLE, text)
    with pytest.raises(BadInput, match=f"a number from 1 to 100 expected, '{text}' found"):
        factor()
