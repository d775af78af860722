"""The entry point of `daq`."""

import sys

import pytest

from daq.cli import main


class Interrupt:
    """Finder that stands for Ctrl-C during the import of the commands."""

    def find_spec(self, name: str, *_: object) -> None:
        if name == "daq.program":
            raise KeyboardInterrupt


def test_ctrl_c_while_the_program_is_loaded_ends_it_with_a_word(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delitem(sys.modules, "daq.program", raising=False)
    monkeypatch.setattr(sys, "meta_path", [Interrupt(), *sys.meta_path])
    with pytest.raises(SystemExit) as exit_:
        main()
    assert exit_.value.code == 130
    assert capsys.readouterr().err == "interrupted before anything moved\n"
