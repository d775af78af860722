"""`ident effects`: the library of physical effects, each explained."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ident.command_options import EFFECT_FILES, JSON, print_result
from recordings.command_line import say_next

if TYPE_CHECKING:
    from ident.dynamics.effects.base import Effect, Quantity


@click.command(
    short_help="List the physical effects of the library, or explain one.", epilog="Example: ident effects stribeck"
)
@click.argument("name", required=False)
@EFFECT_FILES
@JSON
def command(name: str | None, effect_files: tuple[Path, ...], as_json: bool) -> None:
    """List the physical effects of the library, or explain the effect NAME."""
    from ident.dynamics.effects.library import library
    from ident.identification.chosen_effects import check_effect_name

    effects = library(effect_files)
    if name:
        check_effect_name(name, effects)
    if as_json:
        chosen = {name: effects[name]} if name else effects
        print_result({"schema": 1, "effects": [_entry(*pair) for pair in chosen.items()]})
    elif name:
        _explain(name, effects[name])
    else:
        _list(effects)
    if name:
        say_next("ident", "diagnose", "FILE", "--only", name)
    else:
        say_next("ident", "effects", "cogging")


def _list(effects: dict[str, Effect]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table("effect", "description", "equation", title="ident effects NAME explains one", title_justify="left")
    for name, effect in sorted(effects.items()):
        table.add_row(name, effect.sentence, effect.equation)
    Console().print(table)


def _explain(name: str, effect: Effect) -> None:
    from ident.dynamics.effects.base import is_infinite

    entry = _entry(name, effect)
    click.echo(f"{name}: {effect.sentence}\n")
    for title, key in (("Symptom", "symptom"), ("Usual causes", "causes"), ("What to do", "remedy")):
        click.echo(f"{title}: {entry[key]}")
    scope = "one set for the whole robot" if effect.whole_robot else "one set per joint"
    click.echo(
        f"\nEquation: {effect.equation}\nKind: {entry['kind']}, {scope}; mechanisms: {', '.join(effect.mechanisms)}"
    )
    for parameter in entry["parameters"]:
        limits = (parameter["lower"], parameter["upper"])
        low, high = (
            "" if limit is None or is_infinite(limit, parameter["unit"]) else f"{limit:g}" for limit in limits
        )
        physical = f", {low or '-inf'} to {high or 'inf'}" if low or high else ""
        click.echo(f"  {parameter['name']} [{parameter['unit']}]: {parameter['meaning']}{physical}")


def _entry(name: str, effect: Effect) -> dict[str, Any]:
    return {
        "name": name,
        "kind": "additive" if effect.linear else "signal",
        "sentence": effect.sentence,
        "symptom": effect.symptom,
        **{key: getattr(effect, key) for key in ("causes", "remedy", "equation", "latex", "axis")},
        "mechanisms": list(effect.mechanisms),
        "whole_robot": effect.whole_robot,
        "parameters": [_quantity(quantity) for quantity in (*effect.parameters, *effect.shapes)],
    }


def _quantity(quantity: Quantity) -> dict[str, Any]:
    import math

    return {
        "name": quantity.name,
        "unit": quantity.unit.format(effort="N m", position="rad", turn="turn"),
        "meaning": quantity.meaning,
        "lower": quantity.lower if math.isfinite(quantity.lower) else None,
        "upper": quantity.upper if math.isfinite(quantity.upper) else None,
    }
