"""The way through the page in a real browser: choose, fit, see where it fails, add what is missing, save, report."""

import json
import os
import signal
from pathlib import Path

import pytest

from drivers.simulated.seal import unseal
from tests.chromium import PATIENCE
from tests.conftest import Runner
from tests.ident.workbench.conftest import Browser, NewFolder, RunningWorkbench, Serve

pytestmark = pytest.mark.slow
AWAY = 20.0
"""Longer than a browser may be silent [s]."""


@pytest.fixture
def workbench(hidden: NewFolder, serve: Serve) -> RunningWorkbench:
    """A workbench that nobody has used: whether the page asks before a fit depends on what was done before."""
    return serve(hidden())


def rms(browser: Browser, kind: str, step: int, joint: int) -> float:
    """Return an error from the table of the list of steps."""
    return float(browser.text(f"{kind}-{step}-{joint}"))


def test_mission_with_the_mouse(workbench: RunningWorkbench, browser: Browser, ident: Runner) -> None:
    browser.open(workbench.address, width=1400)
    assert "simulated" in browser.text("quality-drives")
    browser.wait_for_text("job", "train fig5a.mcap · validate fig5b.mcap")  # two recordings are chosen at once
    browser.check()

    browser.click("fit")
    browser.at("gaps").wait_for()
    browser.click("tab-residuals")
    assert "explains" in browser.text("residuals-0")
    assert "Above the noise" in browser.text("residuals-2")
    browser.check("where-it-fails")

    browser.click("tab-missing")
    suggested = browser.page.locator('[data-test^="card-"]').first
    suggested.wait_for()
    browser.at("preview").filter(has_text="stribeck").wait_for()
    assert suggested.get_attribute("data-test") == "card-stribeck"
    assert float(browser.text("improvement-stribeck").split()[0]) > 30
    browser.check("what-is-missing")
    browser.click("add-stribeck")
    browser.at("step-2").wait_for()
    for kind in ("train", "held"):
        assert rms(browser, kind, 2, 2) < 0.5 * rms(browser, kind, 1, 2) < rms(browser, kind, 0, 2)

    browser.at("banner-save").wait_for()
    assert "Within the noise" in browser.text("floor")
    browser.check("at-the-floor")
    browser.click("contrast")
    browser.page.mouse.move(0, 400)  # off the button, whose tooltip would lie over the page
    browser.check("at-the-floor-dark")
    browser.click("contrast")
    _check_cli_equivalent(browser, workbench.folder, ident)
    browser.click("banner-save")
    browser.page.get_by_text("Saved as fig5a.model.json").first.wait_for()
    saved = json.loads((workbench.folder / "fig5a.model.json").read_text())
    assert saved["effects"] == ["rod_inertia", "stribeck"]
    browser.click("tab-model")
    browser.screenshot("model")
    browser.click("tab-robot")
    browser.check("robot")
    browser.click("tab-use")
    assert "add up to the torque" in browser.text("causes-0")
    browser.click("use-export")
    browser.at("use-carried").filter(has_text="stribeck").wait_for()
    (exported,) = workbench.folder.glob("*_c")
    assert (exported / "delta_model.c").exists()
    browser.click("torque")
    assert "gravity" in browser.text("torque-printed")
    assert browser.text("torque-command").startswith(
        "ident torque fig5a.model.json fig5a.mcap -o fig5a.fig5a.torque.csv"
    )
    with browser.page.expect_download() as torque:
        browser.click("download-fig5a.fig5a.torque.csv")
    assert torque.value.path().read_bytes() == (workbench.folder / "fig5a.fig5a.torque.csv").read_bytes()
    browser.click("use-compare")
    browser.wait_for_text("use-result", "of that without feed-forward")
    browser.check("use")
    browser.click("tab-record")
    browser.at("commission").get_by_text("Commission one joint").click()
    browser.click("axis-check", "answer-yes")
    browser.wait_for_text("run-messages", "nothing contradicts the rig file")
    browser.check("axis-check")


def _check_cli_equivalent(browser: Browser, folder: Path, ident: Runner) -> None:
    """The commands shown on the page give the errors shown on the page."""
    browser.click("tab-export")
    browser.check()
    code = browser.at("script").filter(has_text="--only stribeck")
    line = next(text for text in code.inner_text().splitlines() if text.startswith("ident diagnose"))
    words = [str(folder / word) if word.endswith(".mcap") else word for word in line.split()[1:]]
    result = ident(*words, "--json")
    assert result.code == 0, result.err
    last = json.loads(result.out)["steps"][-1]
    browser.click("tab-missing")
    for joint in (1, 2, 3):
        assert rms(browser, "train", 2, joint) == pytest.approx(last["train_rms"][joint - 1], abs=6e-5)
        assert rms(browser, "held", 2, joint) == pytest.approx(last["held_out_rms"][joint - 1], abs=6e-5)


def test_mission_with_the_keyboard(workbench: RunningWorkbench, browser: Browser) -> None:
    """At 700 px."""
    browser.open(workbench.address, width=700)
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
    browser.at("use-carried").wait_for()
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


def test_a_browser_that_was_away_goes_on_where_it_was(workbench: RunningWorkbench, browser: Browser) -> None:
    browser.open(workbench.address)
    browser.page.evaluate("window.kept = true; window.socket.disconnect()")
    browser.page.wait_for_timeout(1e3 * AWAY)
    browser.click("tab-model")
    browser.page.evaluate("window.socket.connect()")
    browser.page.get_by_text("Press Fit").first.wait_for()
    assert browser.page.evaluate("window.kept"), "the page was loaded again"


def test_diagnosis_and_the_way_back(workbench: RunningWorkbench, browser: Browser) -> None:
    browser.open(workbench.address)
    browser.click("fit", "tab-missing")
    browser.at("step-1").wait_for()
    os.kill(_worker(workbench), signal.SIGSTOP)  # or a diagnosis may end before a busy browser presses Cancel
    browser.click("diagnose")
    browser.at("cancel").dispatch_event("click")  # a mouse waits until the text of the job beside it stands still
    browser.page.get_by_text("nothing has changed").wait_for()
    browser.click("diagnose")
    finding = browser.page.locator('[data-test="finding-1"]')
    finding.wait_for()
    names = [browser.text(f"finding-{number}") for number in range(2)]
    truth = unseal(workbench.folder / "fig5a.sealed.json")
    assert truth["effects"][0]["name"] in names
    browser.screenshot("diagnosis")
    browser.page.reload()
    assert "stribeck" in browser.text("step-2")
    browser.click("remove-stribeck")
    browser.at("step-3").wait_for()
    browser.at("cancel").dispatch_event("click")  # the analysis, which may have ended already
    browser.page.locator('[data-test="resume-analysis"]:visible, [data-test="floor"]:visible').first.wait_for()
    if browser.at("resume-analysis").is_visible():
        browser.click("resume-analysis")
    assert rms(browser, "held", 3, 2) == pytest.approx(rms(browser, "held", 1, 2), rel=0.01)
    browser.at("floor").filter(has_text="Above the noise").wait_for()
    browser.click("undo")
    browser.at("step-3").wait_for(state="detached")
    browser.click("train-1")
    assert "discards the models" in browser.text("question")
    browser.click("answer-no")
    assert "stribeck" in browser.text("step-2")
    browser.click("tab-export", "reveal")
    browser.page.get_by_text("Hidden: stribeck on joint 2: found.").wait_for()


def _worker(workbench: RunningWorkbench) -> int:
    """Process that fits."""
    threads = Path(f"/proc/{workbench.process.pid}/task").glob("*/children")
    children = [int(child) for thread in threads for child in thread.read_text().split()]
    (worker,) = (child for child in children if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes())
    return worker


def test_dropped_files_become_recordings(tmp_path: Path, serve: Serve, browser: Browser) -> None:
    samples = Path("recordings/samples")
    browser.open(serve(tmp_path).address)
    chooser = browser.page.locator('input[type="file"]')
    chooser.set_input_files(samples / "fig5a.mcap")
    browser.at("train-0").wait_for()
    assert (tmp_path / "fig5a.mcap").read_bytes() == (samples / "fig5a.mcap").read_bytes()
    (tmp_path / "fig5a.mcap").write_bytes(b"mine")
    chooser.set_input_files(samples / "fig5a.mcap")
    browser.page.get_by_text("is not overwritten").wait_for()
    assert (tmp_path / "fig5a.mcap").read_bytes() == b"mine"
    (tmp_path / "fig5a.mcap").unlink()

    chooser.set_input_files(samples / "foreign" / "joint_states_0.mcap")
    browser.at("import-title").wait_for()
    browser.page.keyboard.press("Escape")
    browser.at("import-title").wait_for(state="detached")
    for name in ("scope-fig5a", "scope-fig5b"):
        chooser.set_input_files(samples / "foreign" / f"{name}.csv")
        browser.click("import")
        browser.page.get_by_text("the torque per ampere at the joint [N m/A] expected, none found").first.wait_for()
        browser.at("import-kt").fill("0.35")
        browser.check("import")
        browser.click("import")
        assert browser.text("imported") == f"{name}.mcap is imported"
        browser.click("import-done")
        browser.at("imported").wait_for(state="detached")
    browser.at("job").filter(has_text="train scope-fig5a.mcap · validate scope-fig5b.mcap").wait_for()
    browser.at("quality-torque-gain").filter(has_text="calibrated").wait_for()

    browser.page.get_by_text("Tables and bags (3)").click()
    browser.page.get_by_label("Import joint_states_0.mcap").wait_for()
    assert browser.page.get_by_label("Train: joint_states_0.mcap").count() == 0, "it is no recording"
    browser.page.get_by_label("Import joint_states_0.mcap").click()
    browser.page.get_by_label("joint names in order").fill("left,right,rear")
    browser.click("import")
    assert browser.text("imported") == "joint_states_0-2.mcap is imported"
    browser.click("import-done")
    browser.page.get_by_label("Train: joint_states_0-2.mcap").wait_for()
