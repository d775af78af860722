"""The report is one file, shows the numbers of the JSON, and no name from a file as markup."""

import base64
import hashlib
import json
import re
from dataclasses import replace
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
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        if self.cdata_elem == "script":
            self.scripts.append((self.tags[-1][1], data))

    def attributes(self, name: str) -> list[str]:
        """Values of an attribute of all elements."""
        return [value for _, attributes in self.tags if (value := attributes.get(name))]


def rendered(case: Case, *models: Path) -> str:
    request = contents.ReportRequest((case.model, *models), (case.train,), (case.validate,), (), False)
    return page.render(contents.gather(request, lambda status: None))


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
    targets = [target for name in ("src", "href", "srcset", "data", "action") for target in elements.attributes(name)]
    assert [target for target in targets if not target.startswith("#")] == []
    assert not re.search(r"url\(|@import", (text.split("<style>")[1]).split("</style>")[0])


def test_policy_allows_only_the_embedded_scripts(elements: Elements) -> None:
    (policy,) = [content for content in elements.attributes("content") if "script-src" in content]
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
    assert not {"b", "i"} & {tag for tag, _ in elements.tags}
    # A script element ends at the first `</`, wherever that stands.
    for attributes, body in elements.scripts:
        if "type" in attributes:
            assert "<" not in body
            json.loads(body)


def test_every_figure_has_an_element(elements: Elements) -> None:
    figures = elements.attributes("data-figure")
    assert figures == [attributes["id"] for _, attributes in elements.tags if attributes.get("class") == "plot"]
    assert len(figures) >= 10
    assert len(elements.attributes("id")) == len(set(elements.attributes("id")))


def test_numbers_are_those_of_compare(case: Case, elements: Elements) -> None:
    comparisons = data(elements)["comparisons"]
    assert [entry["held_out"] for entry in comparisons] == [False, True]
    for entry, path in zip(comparisons, (case.train, case.validate), strict=True):
        printed = run("compare", case.model, path, "--json")
        assert entry["comparison"] == json.loads(printed.stdout)


def test_page_says_first_what_speaks_against_the_model(case: Case, tmp_path: Path) -> None:
    content = json.loads(case.model.read_text())
    warning = {"name": "held-out", "significant": True, "sentence": "Another robot?", "kind": "held-out"}
    content["assessment"]["warnings"].append(warning)
    (tmp_path / "m.json").write_text(json.dumps(content))
    text = rendered(replace(case, model=tmp_path / "m.json"))
    assert text.index("Another robot?") < text.index('id="parameters"')


def test_two_models_are_shown_side_by_side(case: Case) -> None:
    other = case.folder / "other.json"
    other.write_bytes(case.model.read_bytes())
    document = data(Elements(rendered(case, other)))
    assert [entry["name"] for entry in document["models"]] == [case.model.name, "other.json"]
    assert len(document["comparisons"]) == 4
    assert document["diagnosis"] is None
