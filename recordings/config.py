"""Reading TOML files into validated, immutable descriptions."""

import json
import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from recordings.errors import BadInput


class ConfigSection(BaseModel):
    """Base of all descriptions: immutable, and a misspelt key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


class JsonDocument(ConfigSection):
    """A document that a command prints, or writes to a file."""

    schema_version: Literal[2] = Field(2, alias="schema")

    def as_json(self) -> dict[str, Any]:
        """The document as it is printed."""
        return self.model_dump(mode="json", by_alias=True)


ModelT = TypeVar("ModelT", bound=ConfigSection)
Positive = Annotated[float, Field(gt=0)]

_LARGEST_FILE = 1_000_000
"""Size limit [bytes]; a device such as /dev/zero has no end."""
_LARGEST = 1e12
"""Largest accepted number, in SI units; its square must not overflow."""


def read_toml(path: Path, model: type[ModelT], what: str) -> ModelT:
    """Read `path` as a `model`; `what` names the kind of file in errors.

    Raises:
        BadInput: the file is missing, is not TOML, or a key is unknown, missing or of the wrong type.
    """
    return validated(toml_content(path, what), model, f"{what} {path}")


def toml_content(path: Path, what: str) -> dict[str, Any]:
    """Content of the TOML file `path`, not validated; `what` names the kind of file in errors.

    Raises:
        BadInput: the file is missing, is not TOML, or a number is too large.
    """
    try:
        content = tomllib.loads(_text(path, what))
    except FileNotFoundError:
        raise BadInput(f"{what} {path} does not exist; check the path") from None
    except RecursionError:
        raise BadInput(f"{what} {path} is nested too deeply; check that it is one") from None
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(f"{what} {path} cannot be read: {error}; check the file") from None
    except tomllib.TOMLDecodeError as error:
        raise BadInput(f"{what} {path} is not valid TOML: {error}; correct it") from None
    _check_magnitudes(content, "", f"{what} {path}")
    return content


def _text(path: Path, what: str) -> str:
    with path.open("rb") as stream:
        content = stream.read(_LARGEST_FILE + 1)
    if len(content) > _LARGEST_FILE:
        raise BadInput(
            f"{what} {path}: at most {_LARGEST_FILE // 1000} kB of TOML expected, more found; check that it is one"
        )
    return content.decode("utf-8")


def _check_magnitudes(content: Any, key: str, where: str) -> None:
    """Raise BadInput at the first number too large to be meant; it would overflow in later computations."""
    if isinstance(content, dict | list):
        for name, value in content.items() if isinstance(content, dict) else enumerate(content):
            _check_magnitudes(value, f"{key}.{name}" if key else str(name), where)
    elif isinstance(content, int | float) and not abs(content) <= _LARGEST:
        shown = "a number of many digits" if isinstance(content, int) else f"{content:g}"
        raise BadInput(f"{where}: '{key}': a number of at most {_LARGEST:g} in size expected, found {shown}")


def validated(content: Any, model: type[ModelT], where: str) -> ModelT:
    """Check `content` against `model`; `where` names its origin in errors.

    Raises:
        BadInput: naming the first offending key, what was expected and what was found.
    """
    try:
        # In JSON mode, strict types still accept an array as a tuple and 1 as a float, as TOML means them.
        return model.model_validate_json(json.dumps(content, default=str))
    except ValidationError as error:
        first = error.errors()[0]
        # Parts in angle brackets are tags of unions (see `recordings.buses`), not keys of the file.
        key = ".".join(str(part) for part in first["loc"] if not str(part).startswith("<"))
        further = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
        raise BadInput(f"{where}: {_explain(key, first)}{further}") from None


def _explain(key: str, error: Any) -> str:
    if error["type"] == "extra_forbidden":
        return f"unknown key '{key}'; check the spelling or remove it"
    if error["type"] == "missing":
        return f"key '{key}' is missing"
    if error["type"] == "value_error":
        return f"{key + ': ' if key else ''}{error['ctx']['error']}"
    return f"'{key}': {error['msg'][0].lower()}{error['msg'][1:]}, found {error['input']!r}"
