"""The workbench shows the store of a fleet and acknowledges its alarms."""

from pathlib import Path

import pytest

from ident.fleet import alarms
from tests.chromium import PATIENCE
from tests.ident.fleet.conftest import filled, rows_of, saved, step
from tests.ident.fleet.test_alarms import a_cause
from tests.ident.workbench.conftest import Browser, Serve


@pytest.mark.slow
def test_alarm_is_acknowledged_with_the_keyboard(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, serve: Serve, browser: Browser
) -> None:
    monkeypatch.setattr(alarms, "cause", lambda *_: a_cause())
    store = filled(tmp_path / "store", rows_of("r07", {"c_c1": step()}))
    (alarm,) = saved(store).alarms
    browser.open(serve(tmp_path, ".", "--store", "store").address, width=700)
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
    assert alarms.load(store).alarms[0].note == "gear replaced"
