"""The entry points of `daq` and `ident`."""

import sys
from types import ModuleType

import pytest

import daq.cli
import ident.cli


class Interrupt:
    """Finder that stands for Ctrl-C during the import of the commands."""

    def find_spec(self, name: str, *_: object) -> None:
        if name in ("daq.program", "ident.program"):
            raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("cli", "said"), [(daq.cli, "interrupted before anything moved\n"), (ident.cli, "interrupted\n")]
)
def test_ctrl_c_while_the_program_is_loaded_ends_it_with_a_word(
    cli: ModuleType, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    for name in ("daq.program", "ident.program"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.setattr(sys, "meta_path", [Interrupt(), *sys.meta_path])
    with pytest.raises(SystemExit) as exit_:
        cli.main()
    assert exit_.value.code == 130
    assert capsys.readouterr().err == said
