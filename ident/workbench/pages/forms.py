"""Fields of the forms on the page."""

from typing import Any

from nicegui import ui
from nicegui.elements.mixins.value_element import ValueElement

from ident.workbench.pages.page import Page, set_test_id


def name_fields(form: str, **fields: ui.element) -> None:
    """Give the fields of a form their look, and identifiers for tests."""
    for name, field in fields.items():
        set_test_id(field, f"{form}-{name}").props("dense outlined")


def as_word(field: ui.number) -> str | None:
    """Return the number of a field as a command takes it, which says what is wrong with it; None: the field is empty.

    The field itself has no limits: it would turn a wrong number into the nearest right one without a word.
    """
    return None if field.value is None else f"{field.value:.15g}"


def keep_fields(page: Page, form: str, **fields: ValueElement[Any]) -> None:
    """As `name_fields`; they have the values that they had when their tab was left."""
    name_fields(form, **fields)
    kept = page.session.display.fields
    for name, field in fields.items():
        key = f"{form}-{name}"
        if (value := kept.get(key)) is not None and value in getattr(field, "options", [value]):
            field.value = value
        field.on_value_change(lambda change, key=key: kept.update({key: change.value}))
