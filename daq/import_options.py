"""What the options of `daq import` hold: callbacks of click, which raise BadInput for any other text."""

import math
from typing import TYPE_CHECKING, Any

import click

from recordings.errors import BadInput

if TYPE_CHECKING:
    from recordings.importing.healing import TimeSpan


def names(context: click.Context, option: click.Parameter, text: str | None) -> tuple[str, ...]:
    """Names that stand between commas, each once."""
    parts = tuple(part.strip() for part in text.split(",")) if text is not None else ()
    if "" in parts or len(set(parts)) < len(parts):
        raise BadInput(
            f"{option.opts[0]}: names such as a,b,c, each once, expected, {text!r} found; correct the list"
        )
    return parts


def name(context: click.Context, option: click.Parameter, text: str | None) -> str | None:
    """A name that is not empty."""
    if text is not None and not text.strip():
        raise BadInput(f"{option.opts[0]}: a name expected, {text!r} found; give one, or leave the option out")
    return text


def kinds(context: click.Context, option: click.Parameter, text: str | None) -> Any:
    """Kinds of joints that stand between commas: revolute or prismatic."""
    parts = tuple(kind.strip() for kind in (text or "revolute").split(","))
    for kind in parts:
        if kind not in ("revolute", "prismatic"):
            raise BadInput(f"--joints: revolute or prismatic expected, {kind!r} found; choose from these")
    return parts


def joint_numbers(context: click.Context, option: click.Parameter, text: str | None) -> tuple[int, ...]:
    """Numbers of joints that stand between commas."""
    parts = text.split(",") if text else []
    if not all(part.strip().isdigit() for part in parts):
        raise BadInput(f"{option.opts[0]}: numbers of joints such as 1,3 expected, {text!r} found; correct the list")
    return tuple(int(part) for part in parts)


def spans(context: click.Context, option: click.Parameter, text: str | None) -> "tuple[TimeSpan, ...]":
    """Spans of time that stand between commas."""
    from recordings.importing.healing import TimeSpan

    spans = []
    for part in text.split(",") if text is not None else []:
        try:
            start, end = map(float, part.split(":"))
        except ValueError:
            start = end = math.nan
        if not -math.inf < start < end < math.inf:
            raise BadInput(f"{option.opts[0]}: times such as 2.5:10 expected, {part!r} found; correct it")
        spans.append(TimeSpan(start, end))
    return tuple(spans)


def numbers(context: click.Context, option: click.Parameter, text: str | None) -> list[float] | None:
    """Numbers above 0 that stand between commas."""
    if text is None:
        return None
    try:
        numbers = [float(number) for number in text.split(",")]
    except ValueError:
        wanted = "numbers such as 1.0 or 1.0,0.9,1.1"
        raise BadInput(f"{option.opts[0]}: {wanted} expected, {text!r} found; correct it") from None
    if not all(0 < number < math.inf for number in numbers):
        remedy = "turn a sign by --map and a factor *-1"
        raise BadInput(f"{option.opts[0]}: numbers above 0 expected, {text!r} found; {remedy}")
    return numbers
