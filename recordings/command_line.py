"""Command-line support for the programs `daq` and `ident`: commands found by file name, errors mapped to exit codes.

One command is one file in the program's `commands` package. The file is named after the command (`-` becomes `_`; a
Python keyword gets a trailing `_`, as in `import_.py`) and holds a `click.Command` called `command`. It is imported
only when the command is used.
"""

import importlib
import math
import os
import pkgutil
import shlex
import signal
import sys
from collections.abc import Callable, Iterable, Sequence
from datetime import datetime
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

import click

from recordings.errors import BadInput, ForeignFile, RunFailed, did_you_mean
from recordings.files import check_new, free_name

INTERRUPTED = 128 + signal.SIGINT
"""Exit code after Ctrl-C, as shells have it."""


def output_name(given: Path | None, default: Path, force: bool = False) -> Path:
    """The name of an output: the one `given`, or the `default`, numbered where `force` does not replace a file."""
    return given or (default if force else free_name(default))


def refuse_existing(
    *paths: Path | None, force: bool = False, read: Sequence[Path] = (), recording: bool = False
) -> None:
    """Check before the work that no output replaces a file without `force`, or an input (`read`) in any case.

    recording: whether the output is one.

    Raises:
        BadInput: two of the `paths` are the same; one of them exists and `force` is False; or it is an input, is
            named like a recording, or is neither file nor folder; or its folder does not exist or is not writable.
    """
    inputs = [input_path.resolve() for input_path in read]
    outputs = [path.resolve() for path in paths if path]
    for path in filter(None, paths):
        if path.resolve() in inputs:
            raise BadInput(f"{path} is one of the inputs and would be replaced; give the output another name")
        if outputs.count(path.resolve()) > 1:
            raise BadInput(f"outputs with different names expected, {path} found twice; give one another name")
        if path.suffix == ".mcap" and not recording:
            raise BadInput(f"{path}: an output expected, a recording's name (.mcap) found; give it another ending")
        if path.exists() and not (path.is_file() or path.is_dir()):
            raise BadInput(f"{path}: a file or a folder expected, something else found; choose another name")
        check_new(path, force, "--force")
        folder = path if path.is_dir() else path.parent
        if not folder.is_dir() and folder.resolve() not in [input_path.parent for input_path in inputs]:
            raise BadInput(f"folder {folder} does not exist; create it, or choose another place")
        if folder.is_dir() and not os.access(folder, os.W_OK):
            raise BadInput(f"folder {folder} cannot be written; change its permissions, or choose another place")


def is_given(parameter: click.Parameter) -> bool:
    """Whether the user gave a parameter of the present command."""
    source = click.get_current_context().get_parameter_source(parameter.name or "")
    return source is click.core.ParameterSource.COMMANDLINE


def refuse_together(option: str, *others: str, because: str) -> None:
    """Refuse a call of the present command that gives `option` beside one of the `others`.

    Raises:
        BadInput: both were given; the sentence ends with the reason.
    """
    parameters = click.get_current_context().command.params
    given = {word for parameter in parameters if is_given(parameter) for word in parameter.opts}
    for other in others:
        if {option, other} <= given:
            raise BadInput(f"either {option} or {other} expected, both found; {because}")


def check_readable(*inputs: Path) -> None:
    """Check that the `inputs` exist, before anything is said about default outputs beside them.

    Raises:
        BadInput: one of them does not exist, or has no name, such as ".".
    """
    for path in inputs:
        if not path.exists():
            raise BadInput(f"{path} does not exist; check the path")
        if not path.name:
            raise BadInput(f"a file expected, the folder '{path}' found; name a file in it")


def say_next(*words: object) -> None:
    """Print the command that comes next on stderr, in one line that can be pasted into a shell."""
    click.echo(f"next: {shlex.join(map(str, words))}", err=True)


def repeated(option: str, values: Iterable[object]) -> list[str]:
    """Words of a command line that give the `option` once for each of the `values`."""
    return [word for value in values for word in (option, str(value))]


def say(text: str, colour: str | None = None) -> None:
    """Print a message for the user on stderr, which leaves stdout to the results."""
    click.secho(text, err=True, fg=colour)


def say_report(level: str, source: str, message: str) -> None:
    """Say what a drive or the cycle reports."""
    say(f"{level}: {source}: {message}", {"warning": "yellow", "error": "red"}.get(level))


class NameChoice(click.Choice[str]):
    """A choice of names that tells which one a mistyped name may mean."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """See click."""
        if str(value) not in self.choices:
            listing = ", ".join(self.choices)
            advice = did_you_mean(str(value), self.choices) or " choose one of them"
            self.fail(f"one of {listing} expected, '{value}' found;{advice}", param, ctx)
        return str(super().convert(value, param, ctx))


class FiniteRange(click.FloatRange):
    """A finite number in a range; click's own type accepts infinity, and NaN in any range."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """See click."""
        number = _converted(super().convert, value, param, ctx)
        if number is None or not math.isfinite(number):
            self.fail(f"a number{_range(self)} expected, '{value}' found; change it", param, ctx)
        return float(number)


class IntegerRange(click.IntRange):
    """An integer in a range."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """See click."""
        number = _converted(super().convert, value, param, ctx)
        if number is None:
            self.fail(f"an integer{_range(self)} expected, '{value}' found; change it", param, ctx)
        return int(number)


class Date(click.DateTime):
    """A day, as 2026-01-05."""

    def __init__(self) -> None:
        super().__init__(["%Y-%m-%d"])

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> datetime:
        """See click."""
        day: datetime | None = _converted(super().convert, value, param, ctx)
        if day is None:
            self.fail(f"a date such as 2026-01-05 expected, '{value}' found; write it so", param, ctx)
        return day


def _converted(convert: Callable[..., Any], *given: Any) -> Any:
    """The value of an option as click converts it; None where it refuses it, in the words of a programmer."""
    try:
        return convert(*given)
    except click.BadParameter:
        return None


def _range(kind: click.FloatRange | click.IntRange) -> str:
    """The range of a number in words, after a blank."""
    low = "" if kind.min is None else f" {'above' if kind.min_open else 'from'} {kind.min:g}"
    high = "" if kind.max is None else f" {'below' if kind.max_open else 'up to'} {kind.max:g}"
    return low + high + (" on" if low and not high and not kind.min_open else "")


class CommandFolder(click.Group):
    """A click group whose commands are the modules of one package."""

    def __init__(self, package: ModuleType, **attrs: Any) -> None:
        super().__init__(context_settings={"help_option_names": ["--help", "-h"]}, **attrs)
        click.version_option(package_name="delta-workbench")(self)
        self._package = package

    def list_commands(self, ctx: click.Context) -> list[str]:
        """See click."""
        return sorted(self._modules())

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """See click."""
        file = self._modules().get(cmd_name)
        if file is None:
            return None
        module = importlib.import_module(f"{self._package.__name__}.{file}")
        command = module.command
        if not isinstance(command, click.Command):
            raise TypeError(f"{module.__name__}.command must be a click.Command, not {type(command).__name__}")
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """See click."""
        mistyped = args[0] not in self._modules() and not args[0].startswith("-")
        if mistyped and not ctx.resilient_parsing:
            advice = did_you_mean(args[0], self._modules()) or f" {ctx.command_path} --help lists the commands"
            ctx.fail(f"No such command '{args[0]}';{advice}")
        return super().resolve_command(ctx, args)

    def _modules(self) -> dict[str, str]:
        """Module name by command name."""
        names = [module.name for module in pkgutil.iter_modules(self._package.__path__)]
        return {name.rstrip("_").replace("_", "-"): name for name in names}


def run(program: Callable[..., Any]) -> NoReturn:
    """Run a click program and exit: 0 done, 1 the run failed, 2 bad usage or input, 3 an alarm, 130 Ctrl-C."""
    sys.exit(_exit_code(program))


def _exit_code(program: Callable[..., Any]) -> int:
    try:
        program(standalone_mode=False)
    except click.exceptions.Exit as exit_request:
        return exit_request.exit_code
    except click.ClickException as error:
        error.show()
        return 2
    except BadInput as error:
        return _print_error(error.for_command if isinstance(error, ForeignFile) else error, 2)
    except RunFailed as error:
        return _print_error(error, error.exit_code)
    except BrokenPipeError:
        # The reader of the output (`| head`) has closed it; redirect stdout so that the flush at exit does not fail.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        prefix = f"{error.filename}: " if error.filename else ""
        return _print_error(f"{prefix}{error.strerror or error}", 2)
    except BaseException as error:
        if not _interrupted(error):
            raise
        click.echo("interrupted", err=True)
        return INTERRUPTED
    return 0


def _interrupted(error: BaseException | None) -> bool:
    """Whether Ctrl-C caused `error`: an interrupted compiler raises errors about its own state."""
    while error is not None and not isinstance(error, KeyboardInterrupt | click.Abort):
        error = error.__cause__ or error.__context__
    return error is not None


def _print_error(error: object, code: int) -> int:
    click.echo(f"error: {error}", err=True)
    return code
