"""Fields of the forms on the page."""

from collections.abc import Callable, Sequence

from nicegui import ui

from ident.workbench.pages.page import set_test_id

_DEFAULT_MACHINE = "default machine"


def name_fields(form: str, **fields: ui.element) -> None:
    """Give the fields of a form their look, and identifiers for tests."""
    for name, field in fields.items():
        set_test_id(field, f"{form}-{name}").props("dense outlined")


def machine_fields(form: str, files: Sequence[str]) -> Callable[[], dict[str, str]]:
    """Draw the fields that describe the simulated machine; return the function that gives them as options of `daq`.

    files: machines to choose from.
    """
    sim = ui.select([_DEFAULT_MACHINE, *files], value=_DEFAULT_MACHINE, label="simulated machine").classes("min-w-36")
    hidden = ui.number("hidden seed", min=0, step=1, format="%d", placeholder="none").classes("w-28")
    hidden.tooltip("Hides effects drawn from this seed in the simulated robot; Reveal opens them")
    name_fields(form, sim=sim, hidden=hidden)

    def options() -> dict[str, str]:
        machine = {"--sim": str(sim.value)} if sim.value != _DEFAULT_MACHINE else {}
        return machine if hidden.value is None else {**machine, "--hidden": str(int(hidden.value))}

    return options
