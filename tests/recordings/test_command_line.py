"""Command-line support: commands found by file name, errors mapped to exit codes."""

import errno
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest.mock import Mock

import click
import pytest
from click.testing import CliRunner

from recordings.command_line import (
    CommandFolder,
    FiniteRange,
    NameChoice,
    check_readable,
    refuse_existing,
    repeated,
    run,
)
from recordings.errors import BadInput, RunFailed


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """A package of commands: one good, one that is no command, one whose import must not happen."""
    folder = tmp_path / "some_commands"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "say_hello.py").write_text(
        "import click\n\n@click.command(short_help='Greet.')\ndef command():\n    click.echo('hello')\n"
    )
    (folder / "import_.py").write_text("import click\n\n@click.command()\ndef command():\n    click.echo('in')\n")
    (folder / "wrong.py").write_text("command = 'not a click command'\n")
    monkeypatch.syspath_prepend(tmp_path)
    import some_commands

    yield some_commands
    for name in [name for name in sys.modules if name.partition(".")[0] == "some_commands"]:
        del sys.modules[name]


def test_commands_are_found_by_file_name(package: ModuleType) -> None:
    program = CommandFolder(package, name="some")
    assert program.list_commands(click.Context(program)) == ["import", "say-hello", "wrong"]
    assert CliRunner().invoke(program, ["say-hello"]).output == "hello\n"
    assert CliRunner().invoke(program, ["import"]).output == "in\n"
    assert CliRunner().invoke(program, ["import-"]).exit_code == 2
    assert "--help" in CliRunner().invoke(program, ["say-hello", "-h"]).output
    assert "some_commands.wrong" not in sys.modules, "only the command that is needed is imported"
    with pytest.raises(TypeError, match=r"some_commands\.wrong\.command must be a click.Command, not str"):
        program.get_command(click.Context(program), "wrong")
    for name, advice in (("sing", "some --help lists the commands"), ("say-helo", "did you mean say-hello?")):
        unknown = CliRunner().invoke(program, [name])
        assert unknown.exit_code == 2
        assert f"No such command '{name}'; {advice}" in " ".join(unknown.output.split())


def caused_by_ctrl_c() -> RuntimeError:
    """An interrupted compiler raises errors about its own state."""
    error = RuntimeError("no compiled object yet")
    error.__context__ = KeyboardInterrupt()
    return error


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (BadInput("no such rig"), 2, "error: no such rig\n"),
        (RunFailed("drive 2: fault"), 1, "error: drive 2: fault\n"),
        (click.UsageError("try --help"), 2, "try --help"),
        (click.exceptions.Exit(3), 3, ""),
        (click.Abort(), 1, "interrupted\n"),
        (KeyboardInterrupt(), 1, "interrupted\n"),
        (PermissionError(errno.EACCES, "Permission denied", "plot.png"), 2, "error: plot.png: Permission denied\n"),
        (OSError("odd"), 2, "error: odd\n"),
        (caused_by_ctrl_c(), 1, "interrupted\n"),
        (None, 0, ""),
    ],
)
def test_errors_become_exit_codes(
    error: BaseException | None, code: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as exit_:
        run(Mock(side_effect=error))
    assert exit_.value.code == code
    output = capsys.readouterr()
    assert output.out == ""
    assert said in output.err
    assert "Traceback" not in output.err
    with pytest.raises(ZeroDivisionError):
        run(Mock(side_effect=ZeroDivisionError))


def test_option_is_repeated_for_each_value() -> None:
    assert repeated("--with", ["stribeck", Path("my.py")]) == ["--with", "stribeck", "--with", "my.py"]
    assert repeated("--with", ()) == []


@pytest.mark.parametrize(
    ("name", "advice"),
    [("serail", "did you mean serial?"), ("ray", "choose one of them"), ("", "choose one of them")],
)
def test_unknown_name_is_refused_with_advice(name: str, advice: str) -> None:
    with pytest.raises(
        click.BadParameter, match=rf"one of dask, serial expected, '{name}' found; {re.escape(advice)}$"
    ):
        NameChoice(["dask", "serial"]).convert(name, None, None)


@pytest.mark.parametrize("text", ["nan", "inf"])
def test_finite_range_refuses_nan_and_infinity(text: str) -> None:
    @click.command()
    @click.option("--length", type=FiniteRange(0, min_open=True))
    def program(length: float) -> None:
        click.echo(length)

    result = CliRunner().invoke(program, ["--length", text])
    assert result.exit_code == 2
    assert f"'--length': a finite number expected, {text} found" in result.output
    assert CliRunner().invoke(program, ["--length", "0.5"]).output == "0.5\n"


@pytest.mark.parametrize("text", [".", "./", "/"])
def test_a_path_without_a_name_is_no_file(text: str) -> None:
    with pytest.raises(BadInput, match="a file expected, the folder"):
        check_readable(Path(text))
    check_readable(Path(__file__))


def test_outputs_replace_nothing_that_is_needed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    model, recording, missing = tmp_path / "a.json", tmp_path / "a.mcap", tmp_path / "none" / "a.json"
    model.touch()
    wrong: list[tuple[tuple[Path | None, ...], dict[str, Any], str]] = [
        ((tmp_path / "." / "a.json",), {"force": True, "read": [model]}, "one of the inputs and would be replaced"),
        ((recording,), {"force": True}, r"recording's name \(\.mcap\) found"),
        ((Path("/dev/null"),), {"force": True}, "a file or a folder expected"),
        ((None, model), {}, "should not exist yet"),
        ((tmp_path / "a.html", tmp_path / "." / "a.html"), {}, "found twice"),
        ((missing,), {}, f"folder {missing.parent} does not exist; create it"),
    ]
    for paths, options, reason in wrong:
        with pytest.raises(BadInput, match=reason):
            refuse_existing(*paths, **options)
    refuse_existing(model, force=True)
    # The input in the same folder is missing too, which is the better reason.
    refuse_existing(missing, tmp_path / "b.json", None, read=[missing.with_suffix(".mcap")])
    monkeypatch.setattr("os.access", lambda path, mode: False)  # root may write anywhere
    with pytest.raises(BadInput, match=f"folder {tmp_path} cannot be written"):
        refuse_existing(tmp_path / "b.json")
