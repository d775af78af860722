"""Options that several commands of `ident` have in common, rules about options, and how results are printed."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from ident.basics import plugins
from ident.basics.model_name import model_stem
from recordings.command_line import FiniteRange, NameChoice, refuse_existing, repeated, say_next
from recordings.errors import BadInput
from recordings.files import free_name

if TYPE_CHECKING:
    from rich.console import Console

    from ident.export.paths import TorquePath
    from ident.identification.model import Model
    from recordings.rig import Rig

_Command = TypeVar("_Command", bound=Callable[..., Any])

FILE = click.Path(path_type=Path)


class PlaceType(click.Path):
    """A path, or the URL of a place in an object store."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """See click."""
        from ident.fleet.places import reached

        return reached(str(value))


PLACE = PlaceType()
ALARM = 3
"""Exit code: done, and an alarm is open."""


def _leave_out_adopted() -> None:
    from ident.dynamics.effects.adopted import FOLDER

    os.environ[FOLDER] = ""


_ADOPTED = click.option(
    "--adopted",
    type=NameChoice(["yes", "no"]),
    default="yes",
    show_default=True,
    expose_value=False,
    is_eager=True,
    callback=lambda context, option, value: _leave_out_adopted() if value == "no" else None,
    help="Use the effects that were adopted with ident effects --adopt.",
)
_EFFECT_FILES = click.option(
    "--effect-file",
    "effect_files",
    multiple=True,
    type=FILE,
    metavar="PY",
    help="Python file with an effect of your own. It is executed.",
)


def EFFECT_FILES(command: _Command) -> _Command:
    """Options that say which effects there are beside those of the library."""
    return _EFFECT_FILES(_ADOPTED(command))


PREPROCESS = click.option(
    "--preprocess",
    type=NameChoice(plugins.names("ident.data.preprocessing")),
    default="parallel",
    show_default=True,
    help="As in fit.",
)
CUTOFF = click.option(
    "--cutoff",
    type=FiniteRange(0.1),
    metavar="HZ",
    help="Cut-off of the low-pass (-3 dB).  [default: from the spectra]",
)
ACCEPT = click.option(
    "--accept",
    multiple=True,
    metavar="KIND",
    help="Use the recordings in spite of data problems of this kind, such as torque-sign. May be repeated.",
)
JSON = click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of tables.")

Rule = Callable[[Mapping[str, object]], str | None]
"""Says what is wrong with the given options, by name with their values; None: nothing."""


class RuledCommand(click.Command):
    """A command that declares which options exclude or need each other."""

    def __init__(self, *arguments: Any, rules: Sequence[Rule] = (), **attributes: Any) -> None:
        super().__init__(*arguments, **attributes)
        self._rules = rules

    def invoke(self, ctx: click.Context) -> Any:
        """See click: the rules of the options are checked first."""
        typed = _typed(ctx)
        for rule in self._rules:
            if problem := rule(typed):
                raise BadInput(problem)
        return super().invoke(ctx)


class DataCommand(RuledCommand):
    """A command that, of data that cannot be right, shows what is wrong in place of its result."""

    def invoke(self, ctx: click.Context) -> Any:
        """See click: data problems are a result, and the command that heals the data comes next."""
        try:
            return super().invoke(ctx)
        except BadInput as error:
            from functools import partial

            from ident.data_problems.implausible import ImplausibleData
            from ident.output.console.printing import show_implausible
            from recordings.data_problems import healing

            if not isinstance(error, ImplausibleData):
                raise
            document = error.document
            show_result(ctx.params.get("as_json", False), document.as_json, partial(show_implausible, document))
            if command := healing(document.data_problems):
                say_next(*command)


def _typed(ctx: click.Context) -> dict[str, Any]:
    """Values of the options that were typed, by their names."""
    typed = click.core.ParameterSource.COMMANDLINE
    names = {max(each.opts, key=len): each.name or "" for each in ctx.command.params if each.name in ctx.params}
    return {option: ctx.params[name] for option, name in names.items() if ctx.get_parameter_source(name) is typed}


def again(*options: str) -> list[str]:
    """Words that repeat those of the `options` that were typed."""
    words, typed = [], _typed(click.get_current_context())
    for option in options:
        value = typed.get(option, ())
        values = value if isinstance(value, tuple) else [value]
        words += repeated(option, (f"{each:g}" if isinstance(each, float) else each for each in values))
    return words


def c_export(model: Path) -> list[object]:
    """Words that write the `model` in C: the end of a road, for nothing comes after it."""
    folder = model.with_name(f"{model_stem(model.name)}_c")
    return ["ident", "export", model, "--to", "c", "-o", free_name(folder, "_c")]


def excludes(option: str, *others: str, note: str = "") -> Rule:
    """Rule that `option` stands beside none of the `others`."""

    def rule(given: Mapping[str, object]) -> str | None:
        found = [other for other in others if {option, other} <= set(given)]
        return f"{found[0]} or {option}{note} expected, both found; leave one out" if found else None

    return rule


def needs(option: str, other: str, otherwise: str) -> Rule:
    """Rule that `option` stands only beside `other`; `otherwise`: what to do without it, or what happens."""

    def rule(given: Mapping[str, object]) -> str | None:
        alone = option in given and other not in given
        return f"{other} expected beside {option}, not found; {otherwise}" if alone else None

    return rule


def belongs(options: Sequence[str], to: str, instead: str, others: Sequence[str]) -> Rule:
    """Rule that `options` say something of what `to` says, and not of the `others`, which have their own."""

    def rule(given: Mapping[str, object]) -> str | None:
        wrong = set(options) & set(given) and set(others) & set(given)
        verb = "belongs" if len(options) == 1 else "belong"
        return f"{' and '.join(options)} {verb} to {to}; {instead}" if wrong else None

    return rule


def one_of(names: Mapping[str, str], why: str, least: int = 0) -> Rule:
    """Rule that at most one, and at `least` so many, of the options is given; names: of each option in a sentence."""

    def rule(given: Mapping[str, object]) -> str | None:
        count, (*first, last) = len(set(names) & set(given)), names.values()
        found = ", several found" if not least else ""
        return None if least <= count <= 1 else f"one of {', '.join(first)} and {last} expected{found}; {why}"

    return rule


def sets(option: str, *others: str, unless: Mapping[str, object] | None = None) -> Rule:
    """Rule that none of the `others` is given, which `option` sets, `unless` it is given so."""

    def rule(given: Mapping[str, object]) -> str | None:
        for other in others:
            if option in given and other in given and given[other] != (unless or {}).get(other):
                value = given[other]
                return f"{other} cannot be combined with {option}, which sets it; '{value}' found; leave one out"
        return None

    return rule


def ends(option: str, suffix: str, what: str, otherwise: str) -> Rule:
    """Rule that the file of an `option` has a `suffix`; what: that is written."""

    def rule(given: Mapping[str, object]) -> str | None:
        name = given.get(option)
        wrong = name is not None and not str(name).endswith(suffix)
        return f"{name}: {what} that ends in {suffix} expected; {otherwise}" if wrong else None

    return rule


def check_choices(effects: Iterable[str], effect_files: Sequence[Path], accepted: Sequence[str] = ()) -> None:
    """Check names of `effects`, as NAME or NAME:1,3, and kinds of data problems, before outputs are looked at.

    Effects of the user are known by the names of their files, which are executed later, and once.
    """
    from ident.data_problems import check_kinds
    from ident.dynamics.effects import adopted, library
    from ident.identification.chosen_effects import check_effect_name

    check_kinds(accepted)
    known = {*library.names(), *(path.stem for path in (*adopted.files(), *effect_files))}
    for choice in effects:
        check_effect_name(choice.partition(":")[0], known)


def check_outputs(*paths: Path | None, force: bool, read: Sequence[Path] = ()) -> None:
    """Check before the work that outputs can be written: no folder in their place, and as `refuse_existing`."""
    for path in filter(None, paths):
        if path.is_dir():
            raise BadInput(f"{path}: a file's name expected, a folder found; choose another name")
    refuse_existing(*paths, force=force, read=read)


def chosen_path(
    model: "Model",
    rig: "Rig",
    recording: Path | None,
    table: Path | None,
    traj: str | None,
    temperature: float | None,
    cycles: int | None = None,
    rate: float | None = None,
) -> "TorquePath | None":
    """The path of a recording, of a table or of a trajectory, whichever is given; None: none is."""
    from ident.export import paths

    if recording:
        return paths.from_recording(recording, model.file)
    if table:
        return paths.from_table(table, rig).at_temperature(temperature)
    return paths.from_trajectory(traj, rig, cycles, rate).at_temperature(temperature) if traj else None


def say_written(**paths: Path | None) -> None:
    """Say on stderr what was written, by what it is."""
    for label, path in paths.items():
        if path:
            click.echo(f"{label}: {path}", err=True)


def print_result(document: Mapping[str, Any] | Callable[[], Mapping[str, Any]]) -> None:
    """Print a `document`, or that which a function returns, as JSON."""
    import json

    click.echo(json.dumps(document() if callable(document) else document, indent=2, allow_nan=False))


def show_result(as_json: bool, document: Callable[[], Mapping[str, Any]], show: "Callable[[Console], None]") -> None:
    """Print a result as a JSON `document`, or let `show` print it on a console."""
    if as_json:
        print_result(document)
    else:
        from rich.console import Console

        show(Console())


def print_listing(head: Sequence[str], rows: Sequence[Sequence[str]], title: str) -> None:
    """Print a table of words."""
    from rich.console import Console

    from ident.output.console.printing import print_table
    from ident.output.tables import ResultTable

    print_table(Console(), ResultTable(head, rows, words=range(len(head)), title=title))
