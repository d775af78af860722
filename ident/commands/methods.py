"""`ident methods`: the methods that estimate parameters, and the settings of each."""

from __future__ import annotations

from typing import Any

import click

from ident.basics import plugins
from ident.command_options import JSON, print_listing, print_result
from recordings.command_line import NameChoice, say_next

MODELS = {None: "Eq. (26)", "lagrange14": "Eqs. (37)-(40)"}
"""Model that a method identifies, by its form."""


@click.command(
    short_help="List the methods of `ident fit`, or the settings of one.", epilog="Example: ident methods pso"
)
@click.argument(
    "name", metavar="[NAME]", required=False, type=NameChoice(plugins.names("ident.estimation.estimators"))
)
@JSON
def command(name: str | None, as_json: bool) -> None:
    """List the methods of `ident fit --method`, or explain the method NAME and its settings.

    A setting is changed by `--set NAME=VALUE`; one with a symbol of the paper also by that, such as c0=0.7.
    """
    methods = [_entry(name)] if name else [_entry(each) for each in plugins.names("ident.estimation.estimators")]
    if as_json:
        print_result({"schema": 1, "methods": methods})
    elif name:
        _explain(methods[0])
    else:
        rows = [
            (each["name"], each["description"], ", ".join(setting["name"] for setting in each["settings"]))
            for each in methods
        ]
        print_listing(("method", "description", "settings"), rows, "ident methods NAME explains one")
    if name is None:
        say_next("ident", "methods", "pso")
    else:
        settings = methods[0]["settings"]
        example = ["--set", "{name}={default}".format_map(settings[0])] if settings else []
        say_next("ident", "fit", "FILE", "--method", name, *example)


def _entry(name: str) -> dict[str, Any]:
    from ident.estimation import estimators

    description, _, details = (estimators.load(name).__doc__ or "").strip().partition("\n\n")
    return {
        "name": name,
        "description": " ".join(description.split()),
        "details": details,
        "model": MODELS[estimators.form(name)],
        "settings": [
            {
                "name": setting.name,
                "symbol": setting.meaning.symbol,
                "values": setting.kind,
                "default": setting.default,
                "meaning": setting.meaning.text,
            }
            for setting in estimators.settings_of(name)
        ],
    }


def _explain(method: dict[str, Any]) -> None:
    click.echo(f"{method['name']}: {method['description']}\n\nModel: {method['model']}\n\n{method['details']}\n")
    click.echo("Settings (ident fit --set NAME=VALUE):" if method["settings"] else "It has no settings.")
    for setting in method["settings"]:
        symbol = f", {setting['symbol']}" if setting["symbol"] else ""
        click.echo(f"  {setting['name']}{symbol} = {setting['default']}: {setting['meaning']} ({setting['values']})")
