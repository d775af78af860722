"""Accessibility of a page in the browser: axe-core, and the size of its controls."""

from importlib.resources import files
from typing import Any

_SERIOUS = ("serious", "critical")
_SMALL_CONTROLS = """() => [...document.querySelectorAll(
    "button, a[href], input, select, textarea, [role=tab], [role=button], [role=switch], [role=slider]")]
    .filter(element => element.offsetParent && element.type !== "file" && !element.closest("[aria-hidden=true]"))
    .filter(element => {
        const box = element.closest(".q-field__control, .q-toggle") || element;
        const font = parseFloat(getComputedStyle(element).fontSize);
        return box.getBoundingClientRect().height < 23.5 || (element.innerText && font < 12);
    })
    .map(element => "smaller than 12 px of text or 24 px of height: " + element.outerHTML.slice(0, 150))"""


def findings(page: Any) -> list[str]:
    """Serious findings of axe-core on `page`, which includes a contrast below 4.5:1, and controls that are small."""
    page.evaluate(files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8"))
    # The thousands of points in plots take minutes, in which the page does not answer its server; if it does not, the
    # server's library fades a notice in.
    options = "{exclude: ['.main-svg', '.nicegui-error-popup']}, {resultTypes: ['violations'], preload: false}"
    violations = page.evaluate(f"axe.run({options})")["violations"]
    serious = [
        f"{violation['id']}: {node['html'][:150]}: {[check['message'] for check in node['any']]}"
        for violation in violations
        if violation["impact"] in _SERIOUS
        for node in violation["nodes"]
    ]
    return [*serious, *page.evaluate(_SMALL_CONTROLS)]
