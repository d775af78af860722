"""`ident effects`: the library of physical effects, each explained."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ident.command_options import EFFECT_FILES, FILE, JSON, RuledCommand, excludes, needs, print_listing, print_result
from recordings.command_line import say_next

if TYPE_CHECKING:
    from ident.dynamics.effects.base import Effect, Quantity

_TEXTS = {"Symptom": "symptom", "Usual causes": "causes", "What to do": "remedy", "To see it, record": "record"}


@click.command(
    cls=RuledCommand,
    rules=[excludes("--adopt", "--drop"), needs("--force", "--adopt", "nothing is replaced without it")],
    short_help="List the physical effects of the library, explain one, or adopt one of your own.",
    epilog="Example: ident effects stribeck",
)
@click.argument("name", required=False)
@EFFECT_FILES
@click.option(
    "--adopt", type=FILE, metavar="PY", help="Check this effect file and use it in every command from now on."
)
@click.option("--drop", metavar="NAME", help="Remove an adopted effect.")
@click.option("--force", is_flag=True, help="Replace an adopted effect of the same name.")
@JSON
def command(
    name: str | None,
    effect_files: tuple[Path, ...],
    adopt: Path | None,
    drop: str | None,
    force: bool,
    as_json: bool,
) -> None:
    """List the physical effects of the library, or explain the effect NAME.

    Adopted effects lie in the folder that the environment variable DELTA_WORKBENCH_EFFECTS names, by default in the
    user's data folder. Their files are executed whenever effects are read.
    """
    from ident.dynamics.effects import adopted
    from ident.dynamics.effects.library import library
    from ident.identification.chosen_effects import check_effect_name

    if drop:
        click.echo(f"dropped: {adopted.drop(drop)}")
        return
    effects = library([*effect_files, *([adopt] if adopt else [])])
    if adopt:
        click.echo(f"adopted: {adopted.adopt(adopt, force)}")
        name = adopt.stem
    if name:
        check_effect_name(name, effects)
    own = {path.stem for path in adopted.files()}
    if as_json:
        chosen = {name: effects[name]} if name else effects
        entries = [_entry(*pair, pair[0] in own) for pair in chosen.items()]
        print_result({"schema": 1, "effects": entries})
    elif name:
        _explain(name, effects[name], name in own)
    else:
        rows = [
            (f"{each} (adopted)" if each in own else each, effect.sentence, effect.equation)
            for each, effect in sorted(effects.items())
        ]
        print_listing(("effect", "description", "equation"), rows, "ident effects NAME explains one")
    if name:
        say_next("ident", "diagnose", "FILE", "--only", name)
    else:
        say_next("ident", "effects", "cogging")


def _explain(name: str, effect: Effect, adopted: bool) -> None:
    from ident.dynamics.effects.base import is_infinite

    entry = _entry(name, effect, adopted)
    click.echo(f"{name}{' (adopted)' if adopted else ''}: {effect.sentence}\n")
    for title, key in _TEXTS.items():
        if entry[key]:
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


def _entry(name: str, effect: Effect, adopted: bool) -> dict[str, Any]:
    return {
        "name": name,
        "adopted": adopted,
        "kind": "additive" if effect.linear else "signal",
        "sentence": effect.sentence,
        **{key: getattr(effect, key) for key in (*_TEXTS.values(), "contains", "equation", "latex", "axis")},
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
