"""The report is one file, shows the numbers of the JSON, and no name from a file as markup."""

import base64
import hashlib
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest

from ident.output.report import contents, page
from tests.ident.output.report.cases import HOSTILE, Case, make_case, run

LARGEST = 10_000_000


class Elements(HTMLParser):
    """All elements of a page with their attributes, and the texts of its scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[tuple[dict[str, str | None], str]] = []
        self.inside = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self.inside = tag == "script"
        if self.inside:
            self.scripts.append((dict(attrs), ""))

    def handle_endtag(self, tag: str) -> None:
        self.inside = False

    def handle_data(self, data: str) -> None:
        if self.inside:
            attributes, text = self.scripts[-1]
            self.scripts[-1] = (attributes, text + data)


def rendered(case: Case, models: int = 1) -> str:
    paths = [case.model, copy_of_model(case)][:models]
    request = contents.ReportRequest(tuple(paths), (case.train,), (case.validate,), (), False)
    return page.render(contents.gather(request, lambda status: None))


def copy_of_model(case: Case) -> Path:
    path = case.folder / "other.json"
    path.write_bytes(case.model.read_bytes())
    return path


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    return make_case(tmp_path_factory.mktemp("reported"))


@pytest.fixture(scope="module")
def text(case: Case) -> str:
    return rendered(case)


@pytest.fixture(scope="module")
def elements(text: str) -> Elements:
    return Elements(text)


def data(elements: Elements) -> dict[str, Any]:
    (embedded,) = [text for attributes, text in elements.scripts if attributes.get("id") == "report-data"]
    document: dict[str, Any] = json.loads(embedded)
    return document


def test_page_references_no_other_file(text: str, elements: Elements) -> None:
    assert len(text.encode()) < LARGEST
    for tag, attributes in elements.tags:
        for name in ("src", "href", "srcset", "data", "action"):
            target = attributes.get(name)
            assert target is None or target.startswith("#"), (tag, target)
    assert not re.search(r"url\(|@import", (text.split("<style>")[1]).split("</style>")[0])


def test_policy_allows_only_the_embedded_scripts(elements: Elements) -> None:
    policy = next(
        attributes["content"]
        for tag, attributes in elements.tags
        if tag == "meta" and attributes.get("http-equiv") == "Content-Security-Policy"
    )
    assert policy is not None
    assert "default-src 'none'" in policy
    code = [body for attributes, body in elements.scripts if "type" not in attributes]
    assert len(code) == 3
    for body in code:
        digest = base64.b64encode(hashlib.sha256(body.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy
    assert "unsafe-inline" not in policy.split("script-src")[1]


def test_hostile_names_are_plain_text(case: Case, text: str, elements: Elements) -> None:
    assert HOSTILE not in text
    assert "&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;&amp;amp;" in text
    assert case.train.name not in text
    names = {tag for tag, _ in elements.tags}
    assert "b" not in names
    assert "i" not in names
    # A script element ends at the first `</`, wherever that stands.
    for attributes, body in elements.scripts:
        if "type" in attributes:
            assert "<" not in body
            json.loads(body)


def test_every_figure_has_an_element(elements: Elements) -> None:
    figures = [attributes["data-figure"] for attributes, _ in elements.scripts if "data-figure" in attributes]
    places = [attributes["id"] for _, attributes in elements.tags if attributes.get("class") == "plot"]
    assert figures == places
    assert len(figures) >= 10
    ids = [attributes["id"] for _, attributes in elements.tags if "id" in attributes]
    assert len(ids) == len(set(ids))


def test_numbers_are_those_of_compare(case: Case, elements: Elements) -> None:
    comparisons = data(elements)["comparisons"]
    assert [entry["held_out"] for entry in comparisons] == [False, True]
    for entry, path in zip(comparisons, (case.train, case.validate), strict=True):
        printed = run("compare", case.model, path, "--json")
        assert entry["comparison"] == json.loads(printed.stdout)


def test_two_models_are_shown_side_by_side(case: Case) -> None:
    elements = Elements(rendered(case, 2))
    document = data(elements)
    assert [entry["name"] for entry in document["models"]] == [case.model.name, "other.json"]
    assert len(document["comparisons"]) == 4
    assert document["diagnosis"] is None
