"""`ident report` as a user types it."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from recordings.errors import BadInput
from tests.foreign.pairs import TRAIN, VALIDATE, Setting, make
from tests.ident.output.report.cases import Case, make_case, run


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    return make_case(tmp_path_factory.mktemp("reported"))


def refused(*arguments: object) -> str:
    result = run("report", *arguments)
    assert isinstance(result.exception, BadInput), result.output
    return str(result.exception)


def test_an_existing_report_is_kept_unless_forced(case: Case, tmp_path: Path) -> None:
    out = tmp_path / "r.html"
    out.write_text("kept")
    arguments = (case.model, case.train, "-o", out, "--no-diagnose")
    assert "--force" in refused(*arguments)
    assert out.read_text() == "kept"
    assert run("report", *arguments, "--force").exit_code == 0
    assert "<!DOCTYPE html>" in out.read_text(encoding="utf-8")[:20_000]
    assert [path.name for path in tmp_path.iterdir()] == ["r.html"]


def test_inputs_are_checked(case: Case, tmp_path: Path) -> None:
    out = tmp_path / "r.html"
    assert "no recording" in refused(case.model, "-o", out)
    assert "no model" in refused(case.train, "-o", out)
    assert "model (.json)" in refused(case.model, case.train, "notes.txt", "-o", out)
    assert "twice" in refused(case.model, case.train, "--validate", case.train, "-o", out)
    assert "replaced" in refused(case.model, case.train, "-o", case.model, "--force")
    assert "does not exist" in refused(case.folder / "no.json", case.train, "-o", out)
    assert "does not exist" in refused(case.model, case.train, "-o", tmp_path / "no" / "r.html", "--no-diagnose")
    assert not list(tmp_path.iterdir())


def test_models_of_a_later_schema_are_refused(case: Case, tmp_path: Path) -> None:
    future = tmp_path / "future.json"
    future.write_text(json.dumps(json.loads(case.model.read_text()) | {"schema": 99}))
    assert "update this software" in refused(future, case.train, "-o", tmp_path / "r.html")


def test_help_is_instant() -> None:
    program = "import sys; from ident.cli import program; program(['report', '--help'], standalone_mode=False); " + (
        "assert not {'plotly', 'jinja2', 'numpy'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", program], check=True, capture_output=True)


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the report on a plant in which an effect is hidden."""
    folder = tmp_path_factory.mktemp("hidden")
    make(folder, ["stribeck"], [0.03], 1, Setting())
    fitted = run("fit", folder / TRAIN, "--method", "ls", "-o", folder / "m.json", "--plots", folder / "plots")
    assert fitted.exit_code == 0, fitted.output
    done = run(
        "report", folder / "m.json", folder / TRAIN, "--validate", folder / VALIDATE, "-o", folder / "report.html"
    )
    assert done.exit_code == 0, done.output
    return folder


@pytest.mark.slow
def test_the_report_contains_the_json_of_diagnose(reported: Path) -> None:
    text = (reported / "report.html").read_text(encoding="utf-8")
    match = re.search(r'<script type="application/json" id="report-data">(.*?)</script>', text, re.DOTALL)
    assert match
    printed = run("diagnose", reported / TRAIN, "--validate", reported / VALIDATE, "--json")
    diagnosis = json.loads(match.group(1))["diagnosis"]
    assert diagnosis == json.loads(printed.stdout)
    assert "absorbed" in {entry["status"] for entry in diagnosis["rejected"]}, "effects that look like the hidden one"
    assert "stribeck" in text
    assert len(text.encode()) < 10_000_000


@pytest.mark.slow
def test_the_report_opens_in_a_browser(reported: Path) -> None:
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        assert os.environ.get("CI") != "true", "chromium expected on PATH, none found; install it"
        pytest.skip("no chromium on PATH")
    from playwright.sync_api import sync_playwright

    messages: list[str] = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.on("console", lambda message: messages.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: messages.append(f"error: {error}"))
        page.on("request", lambda request: messages.append(request.url) if request.url.startswith("http") else None)
        page.goto((reported / "report.html").as_uri())
        page.wait_for_selector("html[data-drawn]", state="attached")
        page.evaluate("document.querySelectorAll('details').forEach(fold => { fold.open = true; })")
        places = page.locator(".plot")
        page.wait_for_selector(f"html[data-drawn='{places.count()}']", state="attached")
        for place in places.all():
            assert place.locator("svg .xy, svg .hm, svg .cartesianlayer").count() > 0, place.get_attribute("id")
        page.click("#theme")
        assert page.evaluate("document.documentElement.dataset.theme") == "dark"
        assert page.evaluate("document.documentElement.scrollWidth") <= 1280
        page.pdf()
        browser.close()
    assert messages == []
