"""Fields of the forms on the page."""

from collections.abc import Callable, Sequence
from typing import Any

from nicegui import ui
from nicegui.elements.mixins.value_element import ValueElement

from ident.workbench.pages.page import Page, set_test_id

_DEFAULT_MACHINE = "default machine"


def name_fields(form: str, **fields: ui.element) -> None:
    """Give the fields of a form their look, and identifiers for tests."""
    for name, field in fields.items():
        set_test_id(field, f"{form}-{name}").props("dense outlined")


def keep_fields(page: Page, form: str, **fields: ValueElement[Any]) -> None:
    """As `name_fields`; they have the values that they had when their tab was left."""
    name_fields(form, **fields)
    kept = page.session.display.fields
    for name, field in fields.items():
        key = f"{form}-{name}"
        if (value := kept.get(key)) is not None and value in getattr(field, "options", [value]):
            field.value = value
        field.on_value_change(lambda change, key=key: kept.update({key: change.value}))


def machine_fields(page: Page, form: str, files: Sequence[str]) -> Callable[[], dict[str, str]]:
    """Draw the fields that describe the simulated machine; return the function that gives them as options of `daq`.

    files: machines to choose from.
    """
    sim = ui.select([_DEFAULT_MACHINE, *files], value=_DEFAULT_MACHINE, label="simulated machine").classes("min-w-36")
    hidden = ui.number("hidden seed", min=0, step=1, format="%d", placeholder="none").classes("w-28")
    hidden.tooltip("Hides effects drawn from this seed in the simulated robot; Reveal opens them")
    keep_fields(page, form, sim=sim, hidden=hidden)

    def options() -> dict[str, str]:
        machine = {"--sim": str(sim.value)} if sim.value != _DEFAULT_MACHINE else {}
        return machine if hidden.value is None else {**machine, "--hidden": str(int(hidden.value))}

    return options
