"""The way through the page in a real browser: choose, fit, see where it fails, add what is missing, save, report."""

import json
import os
import signal
from pathlib import Path

import pytest

from drivers.simulated.seal import unseal
from recordings.reader import read
from tests.conftest import Runner
from tests.ident.workbench.conftest import Browser, RunningWorkbench

pytestmark = pytest.mark.slow


def test_mission_with_the_mouse(own_workbench: RunningWorkbench, browser: Browser, ident: Runner) -> None:
    browser.open(own_workbench.address, width=1400, height=900)
    assert "simulated" in browser.text("quality-drives")
    browser.wait_for_text("job", "train fig5a.mcap · validate fig5b.mcap")  # two recordings are chosen at once
    browser.check()

    browser.click("fit")
    browser.at("gaps").wait_for()
    browser.wait_for_text("best", "stribeck would explain")
    browser.click("tab-residuals")
    assert "explains" in browser.text("residuals-0")
    assert "Above the noise" in browser.text("residuals-2")
    browser.check("where-it-fails")

    browser.page.go_back()
    browser.at("gaps").wait_for()  # Back leads to the tab before
    browser.click("tab-missing")
    suggested = browser.page.locator('[data-test^="card-"]').first
    suggested.wait_for()
    browser.at("preview").filter(has_text="stribeck").wait_for()
    assert suggested.get_attribute("data-test") == "card-stribeck"
    add = browser.at("add-stribeck").bounding_box()
    assert add
    assert add["y"] + add["height"] < 900, "it is seen without scrolling"
    assert float(browser.text("improvement-stribeck").split()[0]) > 30
    browser.check("what-is-missing")
    browser.click("add-stribeck")
    browser.at("step-2").wait_for()
    for kind in ("train", "held"):
        assert browser.rms(kind, 2, 2) < 0.5 * browser.rms(kind, 1, 2) < browser.rms(kind, 0, 2)

    browser.at("banner-save").wait_for()
    assert "Within the noise" in browser.text("floor")
    browser.check("at-the-floor")
    browser.click("contrast")
    browser.page.mouse.move(0, 400)  # off the button, whose tooltip would lie over the page
    browser.check("at-the-floor-dark")
    browser.click("contrast")
    _check_cli_equivalent(browser, own_workbench.folder, ident)
    browser.click("banner-save")
    browser.page.get_by_text("Saved as fig5a.model.json").first.wait_for()
    saved = json.loads((own_workbench.folder / "fig5a.model.json").read_text())
    assert saved["effects"] == ["rod_inertia", "stribeck"]
    browser.click("tab-model")
    browser.screenshot("model")
    browser.click("tab-robot")
    browser.check("robot")
    browser.click("tab-use")
    assert "add up to the torque" in browser.text("causes-0")
    browser.click("use-export")
    browser.at("use-export-printed").filter(has_text="carried.json").wait_for()
    (exported,) = own_workbench.folder.glob("*_c")
    assert (exported / "delta_model.c").exists()
    browser.click("torque")
    assert "gravity" in browser.text("torque-printed")
    assert browser.text("torque-command").startswith(
        "ident torque fig5a.model.json fig5a.mcap -o fig5a.fig5a.torque.csv"
    )
    with browser.page.expect_download() as torque:
        browser.click("download-fig5a.fig5a.torque.csv")
    assert torque.value.path().read_bytes() == (own_workbench.folder / "fig5a.fig5a.torque.csv").read_bytes()
    browser.check("use")
    browser.click("tab-record")
    browser.at("record-model").click()
    browser.page.get_by_role("option", name="fig5a.model.json").click()
    browser.at("record-cycles").fill("1")
    browser.click("record")
    browser.wait_for_text("run-state", "fig5a-2.mcap: done")
    run = read(own_workbench.folder / "fig5a-2.mcap").run
    assert run.feedforward, "its torque was sent along"
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
        assert browser.rms("train", 2, joint) == pytest.approx(last["train_rms"][joint - 1], abs=6e-5)
        assert browser.rms("held", 2, joint) == pytest.approx(last["held_out_rms"][joint - 1], abs=6e-5)


def test_diagnosis_and_the_way_back(own_workbench: RunningWorkbench, browser: Browser) -> None:
    browser.open(own_workbench.address)
    browser.click("fit", "tab-missing")
    browser.at("step-1").wait_for()
    os.kill(_worker(own_workbench), signal.SIGSTOP)  # or a diagnosis may end before a busy browser presses Cancel
    browser.click("diagnose")
    browser.at("cancel").dispatch_event("click")  # a mouse waits until the text of the job beside it stands still
    browser.page.get_by_text("nothing has changed").wait_for()
    browser.click("diagnose")
    finding = browser.page.locator('[data-test="finding-1"]')
    finding.wait_for()
    names = [browser.text(f"finding-{number}") for number in range(2)]
    truth = unseal(own_workbench.folder / "fig5a.sealed.json")
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
    assert browser.rms("held", 3, 2) == pytest.approx(browser.rms("held", 1, 2), rel=0.01)
    browser.at("floor").filter(has_text="Above the noise").wait_for()
    browser.click("undo")
    browser.at("step-3").wait_for(state="detached")
    browser.click("train-1")
    assert "discards the models" in browser.text("question")
    browser.click("answer-no")
    assert "stribeck" in browser.text("step-2")
    browser.click("tab-export", "reveal")
    browser.at("reveal-printed").filter(has_text="found").wait_for()


def _worker(own_workbench: RunningWorkbench) -> int:
    """Process that fits."""
    threads = Path(f"/proc/{own_workbench.process.pid}/task").glob("*/children")
    children = [int(child) for thread in threads for child in thread.read_text().split()]
    (worker,) = (child for child in children if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes())
    return worker
