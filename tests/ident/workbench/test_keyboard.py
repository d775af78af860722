"""The way through the page with the keyboard alone, on a narrow screen, and a browser that was away."""

import pytest

from tests.chromium import PATIENCE
from tests.ident.workbench.conftest import Browser, RunningWorkbench

pytestmark = pytest.mark.slow
AWAY = 20.0
"""Longer than a browser may be silent [s]."""
ACKNOWLEDGED = 4.0
"""Time in which a page says what it has received [s], after which it is not sent again."""


@pytest.mark.essential
def test_mission_with_the_keyboard(own_workbench: RunningWorkbench, browser: Browser) -> None:
    """At 700 px."""
    browser.open(own_workbench.address, width=700)
    browser.press("fit", "tab-residuals")
    browser.at("residuals-1").wait_for()
    browser.check()
    browser.press("tab-missing", "add-stribeck")
    browser.at("banner-save").wait_for()
    browser.check()
    browser.press("undo")
    browser.at("step-2").wait_for(state="detached")
    browser.press("redo", "banner-save")
    browser.page.get_by_text("Saved as fig5a").first.wait_for()
    browser.press("report")
    browser.at("open-report").wait_for()
    with browser.page.context.expect_page(timeout=1e3 * PATIENCE) as opened:
        browser.press("open-report")
    report = opened.value
    report.locator("#plot-steps .main-svg").first.wait_for()
    assert "stribeck" in report.locator("body").inner_text()
    report.close()

    browser.press("tab-use", "use-export")
    browser.at("use-export-printed").wait_for()
    browser.check()
    browser.press("tab-data")  # axe-core mistakes the page below a dialog for its background if it is scrolled
    browser.press("fit")
    browser.at("question").wait_for()
    browser.check()
    browser.press("answer-yes")
    browser.at("question").wait_for(state="detached")
    browser.at("step-2").wait_for(state="detached")
    browser.page.set_viewport_size({"width": 400, "height": 800})
    browser.at("floor").filter(has_text="Above the noise").wait_for()
    browser.check()  # plots that were drawn on the wide page
    for tab in ("data", "model", "residuals", "missing", "export", "use", "record"):
        browser.press(f"tab-{tab}")
        browser.check(f"narrow-{tab}")
        if tab == "residuals":
            _check_one_plot_at_a_time(browser)


def _check_one_plot_at_a_time(browser: Browser) -> None:
    """The page Where is short on a narrow screen, and begins with the joint that is worst."""
    assert browser.page.evaluate("document.documentElement.scrollHeight") <= 3000
    curves = browser.page.get_by_role("figure", name="Residual over the quantities")
    named = "select => select.selectedOptions[0].text"
    assert curves.locator("select").evaluate(named).startswith("joint 2 · velocity [rad/s] · explains ")
    curves.get_by_label("plot after").click()
    browser.page.wait_for_function(
        "plot => plot._fullLayout.xaxis.title.text != 'velocity [rad/s]'", arg=curves.element_handle()
    )
    assert curves.locator("select").evaluate(named).startswith("joint 2 · ")
    assert curves.locator(".xtitle").count() == 1


def test_a_browser_that_was_away_goes_on_where_it_was(own_workbench: RunningWorkbench, browser: Browser) -> None:
    browser.open(own_workbench.address)
    browser.page.get_by_text("Choose a recording with Train").wait_for(state="detached")  # the page is connected
    browser.page.wait_for_timeout(1e3 * ACKNOWLEDGED)
    browser.page.evaluate(
        """delay => {
            window.kept = true;
            const connection = window.socket.io;
            connection.randomizationFactor(0);
            connection.reconnectionDelayMax(delay);
            connection.reconnectionDelay(delay);
            connection.engine.close();
        }""",
        1e3 * AWAY,
    )
    browser.click("tab-model")
    browser.page.get_by_text("Press Fit").first.wait_for()
    assert browser.page.evaluate("window.kept"), "the page was loaded again"
