"""Settings of a method: the annotated fields of a frozen dataclass. A value may also be given as text.

particles: Annotated[int, Meaning("size of the swarm", "N_p")] = 300
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal, get_args, get_origin, get_type_hints

from pydantic import TypeAdapter, ValidationError

from recordings.errors import BadInput, did_you_mean

_KINDS = {int: "an integer", float: "a number"}


@dataclass(frozen=True)
class Meaning:
    """What a setting means, as `ident methods` shows it."""

    text: str
    symbol: str | None = None
    """Symbol of the paper, by which the setting may be given too."""


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

    def value(self, given: Any) -> Any:
        """Convert `given`, a value or its text.

        Raises:
            ValueError: it has another type.
        """
        converted = TypeAdapter(self.annotation).validate_python(given)
        if isinstance(given, bool) or (isinstance(converted, float) and not math.isfinite(converted)):
            raise ValueError(f"{self.kind} expected")
        return converted


def settings_of(settings_class: type[Any]) -> tuple[Setting, ...]:
    """Settings that the dataclass `settings_class` has."""
    hints = get_type_hints(settings_class, include_extras=True)
    settings = []
    for field in fields(settings_class):
        annotation, meaning = get_args(hints[field.name])
        settings.append(Setting(field.name, annotation, field.default, meaning))
    return tuple(settings)


def create(settings_class: type[Any], given: Mapping[str, Any], method: str) -> Any:
    """Create the settings of `method` from `given` values; the others have their defaults.

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
            raise BadInput(
                f"method {method}: {expected}, '{name}' found;{did_you_mean(name, by_name)} "
                f"`ident methods {method}` explains them"
            )
        setting = by_name[name]
        if setting.name in values:
            raise BadInput(f"method {method}: {setting.name} expected once, found twice; leave one out")
        try:
            values[setting.name] = setting.value(value)
        except (ValidationError, ValueError):
            raise BadInput(
                f"method {method}: {setting.name}: {setting.kind} expected, {value!r} found; change it"
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
            raise BadInput(f"--set: NAME=VALUE expected, such as particles=100, '{text}' found; write it so")
        if name in given:
            raise BadInput(f"--set {name}: one value expected, two found; leave one out")
        given[name] = value
    return given
