"""What `--hidden` says: a seed, and when the effects that are drawn from it begin."""

import math
from dataclasses import dataclass

import click


@dataclass(frozen=True)
class HiddenSeed:
    """Seed from which hidden effects are drawn."""

    seed: int
    at: float | None = None
    """When they begin, in simulated time [s]; None: they are there from the beginning."""


def hidden_seed(context: click.Context, option: click.Parameter, value: str | None) -> HiddenSeed | None:
    """What the option says: SEED, or SEED@SECONDS."""
    if value is None:
        return None
    seed, separator, at = value.partition("@")
    try:
        result = HiddenSeed(int(seed), float(at) if separator else None)
    except ValueError:
        result = HiddenSeed(-1)
    if result.seed < 0 or not 0 <= (result.at or 0.0) < math.inf:
        raise click.BadParameter(f"a seed such as 7, or 7@60 to begin at 60 s, expected, {value!r} found")
    return result
