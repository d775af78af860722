"""The progress is shown on terminals only."""

import pytest

from recordings.progress import progress_bar


@pytest.mark.parametrize("terminal", [False, True])
def test_activity_is_shown_on_terminals_only(
    terminal: bool, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("NO_COLOR", raising=False)
    monkeypatch.setenv("FORCE_COLOR", "1" if terminal else "")
    with progress_bar("reading") as show:
        show("fitting [b.mcap]", 3, 10)
    shown = capsys.readouterr()
    assert shown.out == ""
    assert ("fitting [b.mcap]" in shown.err) == terminal
