from pathlib import Path

from ident.workbench.ident_process import run_ident


def test_error_of_a_command_is_returned(tmp_path: Path) -> None:
    error = run_ident(tmp_path, "export", "missing.json", "--to", "c", "-o", "out")
    assert error is not None
    assert error.startswith("error")
    assert "missing.json" in error
    assert run_ident(tmp_path, "export", "--help") is None
