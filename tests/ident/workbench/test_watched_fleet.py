"""The workbench shows the store of a fleet and acknowledges its alarms."""

from pathlib import Path

import pytest

from ident.fleet import alarms
from ident.fleet.store import Store
from tests.chromium import PATIENCE
from tests.ident.workbench.conftest import Browser, Serve


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
