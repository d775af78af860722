"""Command-line support: commands found by file name, errors mapped to exit codes."""

import errno
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import click
import pytest
from click.testing import CliRunner

from recordings.command_line import CommandFolder, FiniteRange, NameChoice, refuse_existing, repeated, run
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
    assert "some_commands.wrong" not in sys.modules, "only the command that is needed is imported"


def test_unknown_command_exits_with_bad_usage(package: ModuleType) -> None:
    result = CliRunner().invoke(CommandFolder(package, name="some"), ["sing"])
    assert result.exit_code == 2
    assert "No such command 'sing'" in result.output
    assert "--help lists the commands" in result.output
    mistyped = CliRunner().invoke(CommandFolder(package, name="some"), ["say-helo"])
    assert "No such command 'say-helo'; did you mean say-hello?" in mistyped.output


def test_help_has_a_short_name(package: ModuleType) -> None:
    program = CommandFolder(package, name="some")
    for words in (["say-hello", "-h"], ["say-hello", "--help"]):
        shown = CliRunner().invoke(program, words)
        assert (shown.exit_code, "--help" in shown.output) == (0, True), words


def test_file_without_a_click_command_raises_type_error(package: ModuleType) -> None:
    program = CommandFolder(package, name="some")
    with pytest.raises(TypeError, match=r"some_commands\.wrong\.command must be a click.Command, not str"):
        program.get_command(click.Context(program), "wrong")


def failing(error: BaseException) -> Callable[..., None]:
    def program(standalone_mode: bool) -> None:
        raise error

    return program


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
    ],
)
def test_errors_become_exit_codes(
    error: BaseException, code: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as exit_:
        run(failing(error))
    assert exit_.value.code == code
    output = capsys.readouterr()
    assert output.out == ""
    assert said in output.err
    assert "Traceback" not in output.err


def test_success_exits_with_zero(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as exit_:
        run(lambda standalone_mode: None)
    assert exit_.value.code == 0
    assert capsys.readouterr().err == ""


def test_unexpected_errors_propagate() -> None:
    with pytest.raises(ZeroDivisionError):
        run(failing(ZeroDivisionError()))


def test_option_is_repeated_for_each_value() -> None:
    assert repeated("--with", ["stribeck", Path("my.py")]) == ["--with", "stribeck", "--with", "my.py"]
    assert repeated("--with", ()) == []


def test_outputs_have_different_names(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="found twice"):
        refuse_existing(tmp_path / "a.html", tmp_path / "." / "a.html")


def test_output_in_a_missing_folder_is_refused_before_the_work(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=f"folder {tmp_path / 'none'} does not exist; create it"):
        refuse_existing(tmp_path / "none" / "model.json")
    # The input in the same folder is missing too, which is the better reason.
    refuse_existing(tmp_path / "none" / "a.model.json", read=[tmp_path / "none" / "a.mcap"])


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


@pytest.mark.parametrize("force", [False, True])
def test_refuse_existing_protects_inputs_and_recordings(tmp_path: Path, force: bool) -> None:
    model, recording = tmp_path / "a.json", tmp_path / "a.mcap"
    for path in (model, recording):
        path.touch()
    with pytest.raises(BadInput, match="one of the inputs and would be replaced"):
        refuse_existing(tmp_path / "." / "a.json", force=force, read=[model])
    with pytest.raises(BadInput, match=r"recording's name \(\.mcap\) found"):
        refuse_existing(recording, force=force)
    with pytest.raises(BadInput, match="a file or a folder expected"):
        refuse_existing(Path("/dev/null"), force=force)


def test_existing_output_is_replaced_only_with_force(tmp_path: Path) -> None:
    model = tmp_path / "a.json"
    model.touch()
    with pytest.raises(BadInput, match="should not exist yet"):
        refuse_existing(None, model)
    refuse_existing(model, force=True)
    refuse_existing(tmp_path / "b.json", None)


def test_folder_without_write_permission_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.access", lambda path, mode: False)  # root may write anywhere
    with pytest.raises(BadInput, match=f"folder {tmp_path} cannot be written"):
        refuse_existing(tmp_path / "a.json")


def test_error_caused_by_ctrl_c_counts_as_interruption(capsys: pytest.CaptureFixture[str]) -> None:
    def compiling(standalone_mode: bool) -> None:
        try:
            raise KeyboardInterrupt
        finally:
            raise RuntimeError("no compiled object yet")

    with pytest.raises(SystemExit) as exit_:
        run(compiling)
    assert exit_.value.code == 1
    assert capsys.readouterr().err == "interrupted\n"


def test_unexpected_runtime_error_propagates() -> None:
    with pytest.raises(RuntimeError, match="a mistake"):
        run(failing(RuntimeError("a mistake")))
