"""Command-line support: commands found by file name, errors mapped to exit codes."""

import errno
import re
import shlex
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest.mock import Mock

import click
import pytest
from click.testing import CliRunner

from daq.program import program as daq_program
from ident.program import program as ident_program
from recordings.command_line import (
    CommandFolder,
    Date,
    FiniteRange,
    IntegerRange,
    NameChoice,
    check_readable,
    refuse_existing,
    repeated,
    run,
    say_next,
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
        (click.Abort(), 130, "interrupted\n"),
        (KeyboardInterrupt(), 130, "interrupted\n"),
        (PermissionError(errno.EACCES, "Permission denied", "plot.png"), 2, "error: plot.png: Permission denied\n"),
        (OSError("odd"), 2, "error: odd\n"),
        (caused_by_ctrl_c(), 130, "interrupted\n"),
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


@pytest.mark.parametrize(
    ("kind", "right", "wrong", "expected"),
    [
        (FiniteRange(0, min_open=True), "0.5", ("nan", "inf", "abc", "", "0"), "a number above 0"),
        (FiniteRange(0.1), "0.1", ("abc", "0"), "a number from 0.1 on"),
        (FiniteRange(-1, 1), "-0.5", ("2",), "a number from -1 up to 1"),
        (IntegerRange(1), "3", ("1.5", "x", "0"), "an integer from 1 on"),
        (IntegerRange(1, 20), "20", ("21",), "an integer from 1 up to 20"),
        (IntegerRange(), "-7", ("seven",), "an integer"),
        (Date(), "2026-01-05", ("5.1.2026", "2026-02-30"), "a date such as 2026-01-05"),
        (NameChoice(["d", "e"]), "d", ("f",), "one of d, e"),
    ],
)
def test_a_value_that_an_option_does_not_take_is_told_in_words(
    kind: click.ParamType, right: str, wrong: Sequence[str], expected: str
) -> None:
    @click.command()
    @click.option("--size", type=kind)
    def program(size: object) -> None:
        click.echo(size)

    for text in wrong:
        result = CliRunner().invoke(program, ["--size", text])
        assert result.exit_code == 2
        assert f"'--size': {expected} expected, '{text}' found; " in result.output
    assert CliRunner().invoke(program, ["--size", right]).output.startswith(right)


OF_CLICK = (*map(type, (click.INT, click.FLOAT)), click.IntRange, click.FloatRange, click.Choice, click.DateTime)


@pytest.mark.parametrize("program", [ident_program, daq_program])
def test_no_option_speaks_the_words_of_click(program: click.Command) -> None:
    pending = [program]
    while pending:
        command = pending.pop()
        if isinstance(command, click.Group):
            context = click.Context(command)
            pending += [command.get_command(context, name) or command for name in command.list_commands(context)]
        for parameter in command.params:
            assert type(parameter.type) not in OF_CLICK, f"{command.name} {parameter.name}"


def test_the_next_command_can_be_pasted_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["ident", "fit", Path("my runs") / f"{'a' * 200}.mcap", "--with", "stribeck:1,2"]
    say_next(*words)
    line, *others = capsys.readouterr().err.splitlines()
    assert not others
    assert shlex.split(line) == ["next:", *map(str, words)]


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
        ((None, model), {}, "a new name expected"),
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
