"""Fleet: the alarms of a store of `ident fleet`, open ones first, and its page."""

from typing import TYPE_CHECKING

from nicegui import ui

from ident.workbench.pages.page import Page, heading, quiet, set_test_id

if TYPE_CHECKING:  # it needs pyarrow, the page without a store does not
    from ident.workbench.state.watched_fleet import WatchedFleet


def draw(page: Page) -> None:
    """Draw the alarms, each open one with a button that acknowledges it."""
    fleet = page.session.fleet
    if fleet is None:
        quiet("No fleet is open; start the workbench with --store DIR.")
        return
    alarms = fleet.alarms()
    count = sum(not alarm.acknowledged for alarm, _ in alarms)
    heading(f"{fleet.name}: {count or 'no'} open alarm{'' if count == 1 else 's'}")
    link = ui.link("Open the page of the fleet: robots over time, trends, evidence", "/fleet", new_tab=True)
    set_test_id(link, "open-fleet")
    for alarm, sentence in alarms:
        with ui.row().classes("items-center gap-3 w-full q-mb-sm"):
            set_test_id(ui.label(sentence).classes("grow basis-96"), f"alarm-{alarm.id}")
            if alarm.acknowledged:
                quiet(f"Acknowledged. {alarm.note}")
            else:
                _draw_acknowledgement(page, fleet, alarm.id)


def _draw_acknowledgement(page: Page, fleet: "WatchedFleet", identity: str) -> None:
    note = set_test_id(ui.input("note").props("dense outlined"), f"note-{identity}")
    note.props["aria-label"] = f"Note on {identity}"
    page.button(
        "Acknowledge",
        f"ack-{identity}",
        lambda: fleet.acknowledge(identity, note.value or ""),
        label=f"Acknowledge {identity}",
    )
