"""What a person does beside the mission: look at candidates, ask about a part, try two explanations, search."""

import json
from pathlib import Path

import pytest

from tests.ident.workbench.conftest import Browser, Serve
from tests.ident.workbench.test_mission import rms

pytestmark = pytest.mark.slow


@pytest.fixture
def fitted(hidden: Path, serve: Serve, browser: Browser) -> Browser:
    """The base model is fitted, and all is looked at."""
    browser.open(serve(hidden, "fig5a.mcap", "fig5b.mcap").address)
    browser.click("tab-missing")
    browser.click("fit")
    browser.at("foretaste").filter(has_text="would take away").wait_for(timeout=120_000)
    return browser


def test_pointing_at_a_card_or_moving_to_it_shows_its_signature(fitted: Browser) -> None:
    assert fitted.text("foretaste").startswith("stribeck")
    fitted.at("card-backlash").hover()
    fitted.at("foretaste").filter(has_text="backlash").wait_for(timeout=120_000)
    fitted.at("card-stribeck").focus()
    fitted.at("foretaste").filter(has_text="stribeck").wait_for(timeout=120_000)
    fitted.shot("signature")
    for _ in ("About", "Add", "the next card"):
        fitted.page.keyboard.press("Tab")
    fitted.at("foretaste").filter(has_not_text="stribeck").wait_for(timeout=120_000)


def test_a_marked_part_is_explained_and_the_effect_added_from_there(fitted: Browser) -> None:
    fitted.click("tab-model")
    fitted.page.get_by_role("button", name="joint 2").click()
    fitted.click("mark")
    fitted.page.wait_for_function(
        "() => document.querySelector('.js-plotly-plot')?._fullLayout?.dragmode == 'select'"
    )
    fitted.page.wait_for_timeout(2000)  # the plot is drawn anew
    box = fitted.page.locator(".js-plotly-plot").bounding_box()
    assert box
    fitted.page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.62 * box["height"])
    fitted.page.mouse.down()
    fitted.page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + 0.8 * box["height"], steps=8)
    fitted.page.mouse.up()
    assert "would explain" in fitted.text("explained")
    assert int(fitted.text("explains-stribeck").split()[1]) > 60
    assert "N m RMS" in fitted.text("special")
    fitted.shot("region")
    fitted.click("add-stribeck")
    fitted.click("tab-missing")
    assert "stribeck" in fitted.text("rung-2", patience=120)


def test_two_explanations_side_by_side(fitted: Browser) -> None:
    fitted.click("add-stribeck")
    fitted.at("rung-2").wait_for(timeout=120_000)
    right = rms(fitted, "held", 2, 2)
    fitted.click("fork", patience=120)
    fitted.click("undo")
    fitted.at("rung-2").wait_for(state="detached", timeout=120_000)
    fitted.click("add-joint_spring", patience=120)
    fitted.at("rung-2").wait_for(timeout=120_000)
    assert fitted.text("branch-A") == "A: stribeck"
    assert fitted.text("branch-B") == "B: joint_spring (present)"
    assert rms(fitted, "held", 2, 2) > 2 * right
    fitted.shot("branches")
    fitted.click("switch-A", patience=120)
    fitted.at("branch-A").filter(has_text="present").wait_for(timeout=120_000)
    assert rms(fitted, "held", 2, 2) == right
    fitted.click("undo", patience=120)
    fitted.at("rung-2").wait_for(state="detached", timeout=120_000)
    fitted.click("redo", patience=120)
    fitted.at("rung-2").wait_for(timeout=120_000)
    assert rms(fitted, "held", 2, 2) == right
    fitted.click("drop-B", patience=120)
    fitted.at("branch-A").wait_for(state="detached", timeout=120_000)


def test_the_swarm_from_the_page(hidden: Path, serve: Serve, browser: Browser) -> None:
    browser.open(serve(hidden, "fig5a.mcap", "fig5b.mcap").address)
    browser.click("tab-swarm")
    browser.at("job").filter(has_text="train fig5a.mcap").wait_for(timeout=120_000)
    # Faster than any hand: a button that has just become visible is heard.
    browser.page.evaluate(
        "() => ['swarm', 'pause'].forEach(name => document.querySelector(`[data-test=${name}]`).click())"
    )
    browser.at("job").filter(has_text="paused").wait_for(timeout=120_000)
    browser.click("resume")
    assert "above its certified minimum" in browser.text("swarm-proof", patience=120)
    assert int(browser.text("swarm-steps").split()[0]) > 50
    browser.shot("swarm")
    browser.click("swarm-save")
    browser.page.get_by_text("Saved fig5a.pso.model.json").wait_for(timeout=120_000)
    saved = json.loads((hidden / "fig5a.pso.model.json").read_text())
    assert saved["method"]["name"] == "pso"
    (hidden / "fig5a.pso.model.json").unlink()
