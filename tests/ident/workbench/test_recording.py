"""Recording from the page: `daq` runs as a separate process that STOP ends safely."""

import re
import signal
import time
from pathlib import Path

import pytest

from recordings.errors import BadInput
from recordings.reader import read
from recordings.recording import Recording
from tests.chromium import PATIENCE
from tests.ident.workbench.conftest import Browser, Serve
from tests.patience import patient

pytestmark = pytest.mark.slow

ENABLED = 0x27
"""Statusword of a drive in Operation enabled under the mask 0x6F, CiA 402."""


def wait_for(out: Path, timeout: float = PATIENCE) -> Recording:
    """Return the recording as soon as it is complete."""
    deadline = time.monotonic() + timeout
    while time.monotonic() < deadline:
        try:
            recording = read(out)
            if recording.complete:
                return recording
        except BadInput:
            pass
        time.sleep(0.2)
    raise AssertionError(f"{out} is not complete after {timeout} s")


def start_recording(browser: Browser, address: str) -> None:
    browser.open(address)
    browser.click("tab-record")
    browser.at("record-cycles").fill("150")  # ten minutes of motion leave time to press STOP
    browser.click("record")
    browser.wait_for_text("run-state", re.compile(r"stream, (0\.[4-9]|[1-9].*)%$"))  # after the lead-in


def assert_stopped_in_mid_motion(recording: Recording) -> None:
    assert recording.run.exit_status == 1
    assert recording.run.reason is not None
    assert "SIGTERM" in recording.run.reason
    assert (recording.repeat >= 0).any()
    assert recording.repeat.max() < 149
    states = recording.statusword & 0x6F
    assert (states == ENABLED).any()
    assert not (states[-1] == ENABLED).any(), "drives must end disabled"
    assert any("SIGTERM" in event.message for event in recording.events)


def test_stop_in_mid_motion_disables_the_drives_and_completes_the_file(
    tmp_path: Path, serve: Serve, browser: Browser
) -> None:
    workbench = serve(tmp_path)
    browser.open(workbench.address)
    browser.click("tab-record")
    browser.at("record-hidden").fill("9")
    browser.click("preflight")
    assert "✓" in browser.at("preflight-check").first.inner_text()
    assert "✓" in browser.at("preflight-dry-run").first.inner_text()
    browser.at("record-hidden").fill("")
    start_recording(browser, workbench.address)
    browser.screenshot("recording-from-here")
    browser.at("commission").get_by_text("Commission one joint").click()
    browser.click("axis-check")
    browser.at("question").wait_for()
    browser.click("stop")  # in reach whatever is asked
    assert_stopped_in_mid_motion(wait_for(tmp_path / "fig5a.mcap"))
    browser.page.get_by_text("The simulated drives were disabled").wait_for()


@pytest.mark.parametrize("lost", ["server interrupted", "server killed", "page left"])
def test_motion_ends_where_no_page_has_a_stop_button(
    lost: str, tmp_path: Path, serve: Serve, browser: Browser
) -> None:
    workbench = serve(tmp_path)
    start_recording(browser, workbench.address)
    if lost == "page left":
        browser.page.goto("about:blank")
    else:
        browser.page.close()
        workbench.process.send_signal(signal.SIGKILL if lost == "server killed" else signal.SIGINT)
        assert workbench.process.wait(timeout=patient(120)) == (-signal.SIGKILL if lost == "server killed" else 0)
    assert_stopped_in_mid_motion(wait_for(tmp_path / "fig5a.mcap"))
    if lost == "server killed":
        again = serve(tmp_path)
        assert again.address == workbench.address
        assert again.process.stdout
        said = [again.process.stdout.readline() for _ in range(3)]
        assert "ended while fig5a.mcap was running" in said[-1]


def test_a_held_button_moves_the_joint(tmp_path: Path, serve: Serve, browser: Browser) -> None:
    """Held with the keyboard to the end, then with the pointer until it is released in mid motion."""
    workbench = serve(tmp_path)
    browser.open(workbench.address)
    browser.click("tab-record")
    browser.at("commission").get_by_text("Commission one joint").click()
    hold, state = browser.at("jog-hold"), browser.at("jog-state")
    hold.wait_for()
    hold.focus()
    browser.page.keyboard.down("Space")
    # A busy machine may delay the keep-alives, which releases the joint.
    state.filter(has_text=re.compile(r"(done|released) after [+-]")).wait_for()
    browser.page.keyboard.up("Space")
    browser.at("jog-by").fill("0.5")
    hold.hover()
    browser.page.mouse.down()
    state.filter(has_text=re.compile(r"stream|stop|disable|of \+0\.5")).wait_for()
    browser.page.mouse.up()
    state.filter(has_text=re.compile(r"released after .* of \+0\.5 rad")).wait_for()
    browser.check("commissioning")
