"""The workbench shows the store of a fleet and acknowledges its alarms."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from ident.fleet import alarms
from ident.fleet.store import Store
from ident.workbench.state.session import WorkbenchSession, open_session
from recordings.errors import BadInput
from tests.chromium import PATIENCE
from tests.ident.workbench.conftest import Browser, Serve


@pytest.fixture
def session(store: Path, tmp_path: Path) -> Iterator[WorkbenchSession]:
    opened = open_session([tmp_path], store=store)
    yield opened
    opened.close()


def test_alarm_is_acknowledged_and_the_tab_drawn_again(session: WorkbenchSession, store: Path) -> None:
    assert session.fleet is not None
    assert session.display.tab == "fleet"
    assert "1 alarm is open" in session.fleet.page()
    ((alarm, sentence),) = session.fleet.alarms()
    assert "stribeck on joint 1 has been there since 2026-01-17" in sentence
    session.fleet.acknowledge(alarm.id, "gear replaced")
    assert session.changes.count(("fleet",)) == 1
    (acknowledged,) = alarms.load(Store(store)).alarms
    assert (acknowledged.acknowledged, acknowledged.note) == (True, "gear replaced")
    with pytest.raises(BadInput, match="an alarm of this store expected"):
        session.fleet.acknowledge("r99-20260101", "")


@pytest.mark.slow
def test_alarm_is_acknowledged_with_the_keyboard(store: Path, tmp_path: Path, serve: Serve, browser: Browser) -> None:
    (alarm,) = alarms.load(Store(store)).alarms
    browser.open(serve(tmp_path, ".", "--store", str(store)).address, width=700)
    browser.press("tab-fleet")
    browser.check("fleet")
    with browser.page.context.expect_page(timeout=1e3 * PATIENCE) as opened:
        browser.press("open-fleet")
    fleet = opened.value
    fleet.get_by_text("1 alarm is open").first.wait_for()
    fleet.close()
    browser.press(f"note-{alarm.id}", key="g")
    browser.page.keyboard.type("ear replaced")
    browser.press(f"ack-{alarm.id}")
    browser.page.get_by_text("Acknowledged. gear replaced").wait_for()
    browser.page.get_by_text("no open alarms").wait_for()
    assert alarms.load(Store(store)).alarms[0].note == "gear replaced"
