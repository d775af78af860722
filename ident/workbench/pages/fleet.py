"""Fleet: the alarms of a store of `ident fleet`, open ones first, and its page."""

from typing import TYPE_CHECKING

from nicegui import ui

from ident.workbench.pages.page import Page, heading, set_test_id

if TYPE_CHECKING:  # it needs pyarrow, the page without a store does not
    from ident.fleet.alarms import Alarm
    from ident.workbench.watched_fleet import WatchedFleet


def draw(page: Page) -> None:
    """Draw the alarms, each open one with a button that acknowledges it."""
    fleet = page.session.fleet
    if fleet is None:
        ui.label("No fleet is open; start the workbench with --store DIR.").classes("quiet")
        return
    alarms = fleet.alarms()
    count = sum(not alarm.acknowledged for alarm in alarms)
    heading(f"{fleet.name}: {count or 'no'} open alarm{'' if count == 1 else 's'}")
    link = ui.link("Open the page of the fleet: robots over time, trends, evidence", "/fleet", new_tab=True)
    set_test_id(link, "open-fleet")
    for alarm in alarms:
        with ui.row().classes("items-center gap-3 w-full q-mb-sm"):
            _draw_alarm(page, fleet, alarm)


def _draw_alarm(page: Page, fleet: "WatchedFleet", alarm: "Alarm") -> None:
    set_test_id(ui.label(fleet.sentence(alarm)).classes("grow basis-96"), f"alarm-{alarm.id}")
    if alarm.acknowledged:
        ui.label(f"Acknowledged. {alarm.note}").classes("quiet")
        return
    note = set_test_id(ui.input("note").props("dense outlined"), f"note-{alarm.id}")
    button = page.button("Acknowledge", f"ack-{alarm.id}", lambda: fleet.acknowledge(alarm.id, note.value or ""))
    note.props["aria-label"], button.props["aria-label"] = f"Note on {alarm.id}", f"Acknowledge {alarm.id}"
