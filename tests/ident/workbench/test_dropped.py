"""Files that the page is given: dropped ones, hostile ones, and a recording that cannot be right."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from ident.workbench.folder import SUFFIX, Folder
from recordings.recording import Recording
from tests.ident.conftest import write_recording
from tests.ident.data_problems.test_mistakes import MISTAKES, robot
from tests.ident.workbench.conftest import Browser, Serve

pytestmark = pytest.mark.slow

IMAGE = "<img src=x onerror=window.hacked=1>"
SCRIPT = "<script>window.hacked=1</script>"


def test_dropped_files_become_recordings(tmp_path: Path, serve: Serve, browser: Browser) -> None:
    samples = Path("recordings/samples")
    browser.open(serve(tmp_path).address)
    chooser = browser.page.locator('input[type="file"]')
    chooser.set_input_files(samples / "fig5a.mcap")
    browser.at("train-0").wait_for()
    assert (tmp_path / "fig5a.mcap").read_bytes() == (samples / "fig5a.mcap").read_bytes()
    (tmp_path / "fig5a.mcap").write_bytes(b"mine")
    chooser.set_input_files(samples / "fig5a.mcap")
    browser.page.get_by_text("the new one is fig5a-2.mcap").wait_for()
    assert (tmp_path / "fig5a.mcap").read_bytes() == b"mine"
    chooser.set_input_files(tmp_path / "fig5a-2.mcap")
    browser.page.get_by_text("fig5a-2.mcap is here already.").wait_for()
    assert not (tmp_path / "fig5a-2-2.mcap").exists()
    for name in ("fig5a", "fig5a-2"):
        (tmp_path / f"{name}.mcap").unlink()
    chooser.set_input_files({"name": "photo.jpg", "mimeType": "image/jpeg", "buffer": b"1"})
    browser.page.get_by_text("photo.jpg: a file of up to 256 MiB expected, of these types: .mcap, ").wait_for()

    for name, text in (("garbage.mcap", "no recording"), ("prose.csv", "It was a dark and stormy night.\n")):
        (samples_of := tmp_path.parent / "elsewhere").mkdir(exist_ok=True)
        (samples_of / name).write_text(text)
        chooser.set_input_files(samples_of / name)
        refusal = browser.page.locator(".q-notification").filter(has_text=name)
        refusal.wait_for()
        said = refusal.inner_text()
        assert " --" not in said, "a page has no options"
        assert "ident.read" not in said, "nor is it Python"
        assert str(tmp_path) not in said, "the folder is known"
        assert not (tmp_path / name).exists(), "it is not taken"
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


def test_names_and_metadata_of_a_hostile_recording_are_shown_as_text(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path: Path, serve: Serve, browser: Browser
) -> None:
    recording = make(path=tmp_path / "evil.mcap", rate=250.0)
    rig = recording.rig.model_copy(update={"name": IMAGE})
    run = recording.run.model_copy(update={"trajectory": SCRIPT, "software": IMAGE})
    write(replace(recording, rig=rig, run=run))
    (tmp_path / f"{IMAGE}.mcap").write_bytes((tmp_path / "evil.mcap").read_bytes())
    with (tmp_path / "huge.mcap").open("wb") as file:  # two recordings alone would be chosen at once
        file.truncate(2**30)
    browser.open(serve(tmp_path).address)
    page, names = browser.page, Folder.at(tmp_path).names(SUFFIX)
    page.get_by_text(f"{IMAGE}.mcap").wait_for()
    browser.click(f"train-{names.index('evil.mcap')}")
    assert IMAGE in browser.text("quality-rig")
    assert SCRIPT in browser.text("quality-motion")
    browser.click(f"train-{names.index(f'{IMAGE}.mcap')}")
    page.get_by_text("a plain file name").wait_for()
    browser.click(f"train-{names.index('huge.mcap')}")
    page.get_by_text("is not an MCAP file").wait_for()
    browser.screenshot("hostile")
    assert page.evaluate("window.hacked") is None
    assert not page.locator("img[src=x]").count()


def test_a_recording_that_cannot_be_right_is_healed(tmp_path: Path, serve: Serve, browser: Browser) -> None:
    flipped = MISTAKES["flipped torque"].change(robot(3))
    for name in ("a", "b"):
        write_recording(replace(flipped, path=tmp_path / f"{name}.mcap"))
    browser.open(serve(tmp_path).address)
    browser.click("tab-data")
    browser.wait_for_text("problem-torque-sign", "joint 1")
    browser.check("data-problem")
    browser.click("heal-torque-sign")
    browser.page.get_by_text("a-healed.mcap").first.wait_for()
    browser.at("problem-torque-sign").wait_for(state="detached")
    browser.check("healed")
    assert (tmp_path / "a-healed.mcap").exists()
