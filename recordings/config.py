"""Reading TOML files into validated, immutable descriptions."""

import json
import textwrap
import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from recordings.errors import BadInput
from recordings.limits import bounded_text, check_keys, parsed


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
"""Size limit [bytes]."""
_LARGEST = 1e12
"""Largest accepted number, in SI units."""
_KEYS_WIDTH = 400
"""Characters for the keys that an error names beside the first: what `daq rig propose` asks of three drives."""


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
    text, where = bounded_text(path, what, _LARGEST_FILE), f"{what} {path}"
    check_keys(text, where)
    return parsed(tomllib.loads, text, where, "TOML", _LARGEST)


def validated(content: Any, model: type[ModelT], where: str) -> ModelT:
    """Check `content` against `model`; `where` names its origin in errors.

    Raises:
        BadInput: naming the first offending key, what was expected and what was found, and the other keys.
    """
    try:
        # In JSON mode, strict types still accept an array as a tuple and 1 as a float, as TOML means them.
        return model.model_validate_json(json.dumps(content, default=str))
    except ValidationError as error:
        first, *others = error.errors()
        keys = textwrap.shorten(", ".join(map(_key, others)), _KEYS_WIDTH, placeholder=" ...")
        further = f" (and {len(others)} more: {keys})" if others else ""
        raise BadInput(f"{where}: {_explain(_key(first), first)}{further}") from None


def _key(error: Any) -> str:
    # Parts in angle brackets are tags of unions (see `recordings.buses`), not keys of the file.
    return ".".join(str(part) for part in error["loc"] if not str(part).startswith("<"))


def _explain(key: str, error: Any) -> str:
    if error["input"] == "?":
        # `daq rig propose` writes it where no drive states a value.
        return f"'{key}' is \"?\": nothing states it; put in the value that its comment asks for"
    if error["type"] == "extra_forbidden":
        return f"unknown key '{key}'; check the spelling or remove it"
    if error["type"] == "missing":
        return f"key '{key}' is missing; add it"
    if error["type"] == "value_error":
        return f"{key + ': ' if key else ''}{error['ctx']['error']}"
    return f"'{key}': {error['msg'][0].lower()}{error['msg'][1:]}, found {error['input']!r}"
