"""`ident report` as a user types it."""

import json
import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from tests.chromium import tab
from tests.foreign.pairs import TRAIN, VALIDATE, Setting, make
from tests.ident.conftest import write_recording
from tests.ident.data.test_frequency_response import recording as multisine_recording
from tests.ident.output.report.cases import Case, make_case, run

_LEGEND_ABOVE_TITLE = """() => {
    const [legend, title] = [".legend", ".annotation"].map(
        name => document.querySelector("#plot-steps " + name)?.getBoundingClientRect());
    return legend && title && legend.bottom <= title.top;
}"""
"""Whether the legend is above the first title, as soon as its height is known."""
A4_HEIGHT = 1032
"""Of the printed part of a page [px]."""


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    return make_case(tmp_path_factory.mktemp("reported"))


@pytest.mark.slow
def test_a_frequency_response_is_a_part_of_the_report(case: Case, tmp_path: Path) -> None:
    response = write_recording(replace(multisine_recording(cycles=2), path=tmp_path / "joint2.mcap"))
    out = tmp_path / "r.html"
    run("report", case.model, case.train, "--response", response, "-o", out, "--no-diagnose")
    page = out.read_text(encoding="utf-8")
    assert 'id="plot-response-1"' in page
    assert "ident response joint2.mcap --json" in page


def test_a_comparison_prints_its_tables_and_writes_a_page(case: Case, tmp_path: Path) -> None:
    page = tmp_path / "both.html"
    done = run("compare", case.model, case.validate, case.train, "--report", page)
    texts = (
        "SIMULATED",
        "RELATIVE",
        "noise floor",
        "reversal",
        "cruise",
        "squared residual",
        "Worst intervals",
        "b&.mcap",
    )
    assert [text for text in texts if text not in done.stdout] == []
    shown = set(re.findall(r'data-figure="plot-([a-z0-9-]+)"', page.read_text(encoding="utf-8")))
    assert {"torque-1", "torque-2", "phases", "curves", "spectrum", "worst-1"} <= shown


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the report on a plant in which an effect is hidden."""
    folder = tmp_path_factory.mktemp("hidden")
    make(folder, ["stribeck"], [0.03], 1, Setting())
    run("fit", folder / TRAIN, "--method", "ls", "-o", folder / "m.json")
    run("report", folder / "m.json", folder / TRAIN, "--validate", folder / VALIDATE, "-o", folder / "report.html")
    return folder


@pytest.mark.slow
def test_the_report_contains_the_json_of_diagnose(reported: Path) -> None:
    text = (reported / "report.html").read_text(encoding="utf-8")
    match = re.search(r'<script type="application/json" id="report-data">(.*?)</script>', text, re.DOTALL)
    assert match
    printed = run("diagnose", reported / TRAIN, "--validate", reported / VALIDATE, "--json")
    diagnosis = json.loads(match.group(1))["diagnosis"]
    assert diagnosis == json.loads(printed.stdout)
    assert re.findall(r'<section id="([a-z-]+)">', text)[:4] == ["steps", "findings", "before-after", "remains"]
    assert text.index('id="plot-finding-1"') < text.index("Usual causes"), "in the order of the story"
    assert text.index('id="top"') < text.index('<div class="tiles">') < text.index('id="plot-steps"')
    assert len(text.encode()) < 10_000_000


@pytest.mark.slow
def test_the_report_opens_in_a_browser(reported: Path) -> None:
    messages: list[str] = []
    with tab() as page:
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
    assert messages == []


@pytest.mark.slow
def test_plots_stand_below_each_other_on_a_narrow_screen(reported: Path) -> None:
    with tab() as page:
        for width in (700, 400):
            page.set_viewport_size({"width": width, "height": 800})
            page.goto((reported / "report.html").as_uri())
            page.wait_for_selector("html[data-drawn]", state="attached")
            page.wait_for_function(_LEGEND_ABOVE_TITLE)
            assert not page.evaluate("document.getElementById('contents').open")
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            boxes = [plot.bounding_box() for plot in page.locator("#plot-steps .bglayer .bg").all()]
            assert len(boxes) == 3
            assert all(box["width"] > 0.4 * width for box in boxes)
            for above, below in pairwise(boxes):
                assert below["y"] > above["y"] + above["height"] + 40, "room for labels and title"


@pytest.mark.slow
def test_a_double_click_shows_the_whole_recording_and_paper_takes_twelve_pages(reported: Path) -> None:
    with tab() as page:
        page.goto((reported / "report.html").as_uri())
        page.wait_for_selector("html[data-drawn]", state="attached")
        plot = page.locator("#before-after details[open] .plot")
        plot.scroll_into_view_if_needed()
        size = "plot => plot._fullLayout.xaxis.range[1] - plot._fullLayout.xaxis.range[0]"
        first = plot.evaluate(size)
        plot.locator(".nsewdrag").first.dblclick()
        for _ in range(100):
            if plot.evaluate(size) > 2 * first:
                break
            page.wait_for_timeout(100)
        assert plot.evaluate(size) > 2 * first

        paper = page.pdf(prefer_css_page_size=True)
        assert len(re.findall(rb"/Type\s*/Page\b", paper)) <= 12
        page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
        heights = page.locator(".js-plotly-plot").evaluate_all("plots => plots.map(plot => plot.offsetHeight)")
        assert max(heights) < 0.45 * A4_HEIGHT, "a plot that does not fit leaves less than half a page empty"
