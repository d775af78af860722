"""The page *Use it*: torque by cause, an export with its losses, and the comparison, at three widths."""

import pytest

from tests.ident.workbench.conftest import ARTEFACTS, Browser, RunningWorkbench

pytestmark = pytest.mark.slow


def test_model_is_put_to_use(workbench: RunningWorkbench, browser: Browser) -> None:
    browser.open(f"{workbench.address}", width=1400)
    browser.click("tab-use")
    browser.page.get_by_text("Fit a model first").wait_for()
    browser.click("fit")
    browser.at("causes-0").wait_for()
    assert "add up to the torque" in browser.text("causes-0")
    browser.click("use-export")
    browser.at("use-carried").wait_for()
    assert "rod_inertia" in browser.text("use-carried")
    (folder,) = workbench.folder.glob("*_c")
    assert (folder / "delta_model.c").exists()
    browser.click("use-compare")
    browser.at("use-result").wait_for()
    assert "of that without feed-forward" in browser.text("use-result")
    for width in (1400, 700, 400):
        browser.open(workbench.address, width=width)
        browser.press("tab-use")
        browser.at("use-result").wait_for()
        browser.screenshot(f"use-{width}")
        browser.check_accessibility()
        # The whole page, of which the results are the lower part.
        browser.page.screenshot(path=ARTEFACTS / f"use-{width}-all.png", full_page=True)
