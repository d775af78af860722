"""Model selection in a real browser: open, fit, analyse the residual, add the suggested effect, compare errors."""

import json
from pathlib import Path

import pytest

from drivers.simulated.seal import unseal
from tests.conftest import Runner
from tests.ident.workbench.conftest import Browser, Serve

pytestmark = pytest.mark.slow


def rms(browser: Browser, kind: str, step: int, joint: int) -> float:
    """Return an error from the table of the ladder."""
    return float(browser.text(f"{kind}-{step}-{joint}"))


def test_missing_effect_is_suggested_and_reduces_the_errors(
    hidden: Path, serve: Serve, browser: Browser, ident: Runner
) -> None:
    workbench = serve(hidden, "fig5a.mcap", "fig5b.mcap")
    browser.open(workbench.address)
    assert "simulated" in browser.text("quality-drives")
    browser.screenshot("recording")

    browser.click("tab-missing")
    browser.click("fit")
    browser.at("step-1").wait_for()
    suggested = browser.page.locator('[data-test^="card-"]').first
    suggested.wait_for()
    assert suggested.get_attribute("data-test") == "card-stribeck"
    assert float(browser.text("improvement-stribeck").split()[0]) > 30

    browser.click("tab-residuals")
    assert "Above the noise" in browser.text("residuals-1")
    assert "oint 2" in browser.text("residuals-2")
    browser.screenshot("where-it-fails")

    browser.click("tab-missing")
    browser.click("add-stribeck")
    browser.at("step-2").wait_for()
    assert "stribeck" in browser.text("step-2")
    for kind in ("train", "held"):
        assert rms(browser, kind, 2, 2) < 0.5 * rms(browser, kind, 1, 2) < rms(browser, kind, 0, 2)
    suggested.wait_for()
    browser.screenshot("what-is-missing")
    browser.click("contrast")
    browser.screenshot("what-is-missing-dark")

    _check_cli_equivalent(browser, hidden, ident)

    browser.click("tab-missing")
    browser.click("diagnose")
    finding = browser.page.locator('[data-test="finding-1"]')
    finding.wait_for()
    names = [browser.text(f"finding-{number}") for number in range(2)]
    truth = unseal(hidden / "fig5a.sealed.json")
    assert truth["effects"][0]["name"] in names
    browser.screenshot("diagnosis")


def _check_cli_equivalent(browser: Browser, folder: Path, ident: Runner) -> None:
    """The commands shown on the page give the errors shown on the page."""
    browser.click("tab-export")
    code = browser.at("script").filter(has_text="--only stribeck")
    line = next(text for text in code.inner_text().splitlines() if text.startswith("ident diagnose"))
    words = [str(folder / word) if word.endswith(".mcap") else word for word in line.split()[1:]]
    result = ident(*words, "--json")
    assert result.code == 0, result.err
    last = json.loads(result.out)["rungs"][-1]
    browser.click("tab-missing")
    for joint in (1, 2, 3):
        assert rms(browser, "train", 2, joint) == pytest.approx(last["train_rms"][joint - 1], abs=6e-5)
        assert rms(browser, "held", 2, joint) == pytest.approx(last["validate_rms"][joint - 1], abs=6e-5)


def test_undo_remove_and_a_reload(hidden: Path, serve: Serve, browser: Browser) -> None:
    workbench = serve(hidden, "fig5a.mcap", "fig5b.mcap")
    browser.open(workbench.address)
    browser.click("tab-missing")
    browser.click("fit")
    browser.at("add-stribeck").wait_for()
    browser.click("diagnose")
    browser.click("cancel")
    browser.page.get_by_text("nothing has changed").wait_for()
    browser.click("add-stribeck")
    browser.at("step-2").wait_for()
    browser.page.reload()
    assert "stribeck" in browser.text("step-2")
    browser.click("remove-stribeck")
    browser.at("step-3").wait_for()
    assert rms(browser, "held", 3, 2) == pytest.approx(rms(browser, "held", 1, 2), rel=0.01)
    browser.click("undo")
    browser.at("step-3").wait_for(state="detached")
    assert "stribeck" in browser.text("step-2")
    browser.click("tab-model")
    browser.screenshot("model")
    browser.click("tab-robot")
    browser.screenshot("robot")
    browser.click("tab-export")
    browser.click("save")
    browser.page.get_by_text("Saved fig5a.model.json").wait_for()
    saved = json.loads((hidden / "fig5a.model.json").read_text())
    assert saved["effects"] == ["rod_inertia", "stribeck"]


def test_uploaded_file_never_replaces_a_recording(tmp_path: Path, serve: Serve, browser: Browser) -> None:
    source = Path("recordings/samples/fig5a.mcap")
    browser.open(serve(tmp_path).address)
    chooser = browser.page.locator('input[type="file"]')
    chooser.set_input_files(source)
    browser.at("train-0").wait_for()
    assert (tmp_path / "fig5a.mcap").read_bytes() == source.read_bytes()
    (tmp_path / "fig5a.mcap").write_bytes(b"mine")
    chooser.set_input_files(source)
    browser.page.get_by_text("is not overwritten").wait_for()
    assert (tmp_path / "fig5a.mcap").read_bytes() == b"mine"
