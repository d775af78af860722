"""Settings of a method or an export: the annotated fields of a frozen dataclass. A value may be given as text.

particles: Annotated[int, Meaning("size of the swarm", "N_p")] = 300
"""

import math
import operator
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal, get_args, get_origin, get_type_hints

from pydantic import TypeAdapter, ValidationError

from recordings.errors import BadInput, did_you_mean

_KINDS = {int: "an integer", float: "a number", str: "a text"}
# How a limit of `Meaning` is said, and what compares a value with it.
_LIMITS = {
    "least": ("from", operator.ge),
    "above": ("above", operator.gt),
    "most": ("to", operator.le),
    "below": ("to below", operator.lt),
}


@dataclass(frozen=True)
class Meaning:
    """What a setting means, as `ident methods` shows it."""

    text: str
    symbol: str | None = None
    """Symbol of the paper, by which the setting may be given too."""
    least: float | None = None
    above: float | None = None
    most: float | None = None
    below: float | None = None
    """Limits of a number: those that are allowed (`least`, `most`) and those that are not (`above`, `below`)."""


@dataclass(frozen=True)
class Setting:
    """One setting of a method."""

    name: str
    annotation: Any
    default: Any
    meaning: Meaning

    @property
    def kind(self) -> str:
        """Allowed values in words."""
        if get_origin(self.annotation) is Literal:
            return " or ".join(get_args(self.annotation))
        return _KINDS[self.annotation]

    @property
    def limits(self) -> dict[str, float]:
        """The limits that it has, by their names in `Meaning`."""
        return {name: limit for name in _LIMITS if (limit := getattr(self.meaning, name)) is not None}

    @property
    def expected(self) -> str:
        """Kind and limits in words."""
        return " ".join([self.kind, *(f"{_LIMITS[name][0]} {limit:g}" for name, limit in self.limits.items())])

    def value(self, given: Any) -> Any:
        """Convert `given`, a value or its text.

        Raises:
            ValueError: it has another type, or is out of range.
        """
        converted = TypeAdapter(self.annotation).validate_python(given)
        unlike = isinstance(given, bool) or (isinstance(converted, float) and not math.isfinite(converted))
        if unlike or not all(_LIMITS[name][1](converted, limit) for name, limit in self.limits.items()):
            raise ValueError(f"{self.expected} expected")
        return converted


def settings_of(settings_class: type[Any]) -> tuple[Setting, ...]:
    """Settings that the dataclass `settings_class` has."""
    hints = get_type_hints(settings_class, include_extras=True)
    settings = []
    for field in fields(settings_class):
        annotation, meaning = get_args(hints[field.name])
        settings.append(Setting(field.name, annotation, field.default, meaning))
    return tuple(settings)


def create(settings_class: type[Any], given: Mapping[str, Any], owner: str, advice: str) -> Any:
    """Create the settings of the `owner`, such as "method pso", from `given` values; the others have their defaults.

    advice: where they are explained.

    Raises:
        BadInput: there is no such setting, or a value has another type or is out of range.
    """
    known = settings_of(settings_class)
    by_name = {name: setting for setting in known for name in (setting.name, setting.meaning.symbol) if name}
    values: dict[str, Any] = {}
    for name, value in given.items():
        if name not in by_name:
            names = ", ".join(setting.name for setting in known)
            expected = f"a setting of {names} expected" if names else "no settings expected"
            raise BadInput(f"{owner}: {expected}, '{name}' found;{did_you_mean(name, by_name)} {advice}")
        setting = by_name[name]
        if setting.name in values:
            raise BadInput(f"{owner}: {setting.name} expected once, found twice; leave one out")
        try:
            values[setting.name] = setting.value(value)
        except (ValidationError, ValueError):
            raise BadInput(
                f"{owner}: {setting.name}: {setting.expected} expected, {value!r} found; change it"
            ) from None
    return settings_class(**values)


def parse(texts: tuple[str, ...]) -> dict[str, str]:
    """Parse settings as a user types them, NAME=VALUE.

    Raises:
        BadInput: a text has another form, or a name occurs twice.
    """
    given: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise BadInput(f"--set: NAME=VALUE expected, '{text}' found; write it so")
        if name in given:
            raise BadInput(f"--set {name}: one value expected, two found; leave one out")
        given[name] = value
    return given
