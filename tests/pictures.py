"""The picture of README.md: what the report of the demo shows of the finding and of the error.

`make pictures` runs it: `python -m tests.pictures REPORT.html PICTURE.png`.
"""

import sys
from pathlib import Path

from tests.chromium import tab

_WIDTH = 1100
_ARRANGE = """() => {
    const figure = selector => document.querySelector(selector).closest("figure");
    const shown = [figure("#plot-finding-1"), figure("#plot-steps")];
    const width = shown[0].offsetWidth;
    document.body.replaceChildren(...shown);
    Object.assign(document.body.style,
        {display: "block", boxSizing: "content-box", width: `${width}px`, padding: "16px", background: "white"});
}"""


def picture(report: Path, out: Path) -> None:
    """Write the residual without and with the first finding, and the error of each model, as a PNG file."""
    with tab() as page:
        page.set_viewport_size({"width": _WIDTH, "height": 900})
        page.goto(report.absolute().as_uri())
        page.locator("#plot-steps .main-svg").first.wait_for()
        page.evaluate("document.querySelector('#plot-finding-1').scrollIntoView()")
        page.locator("#plot-finding-1 .main-svg").first.wait_for()
        page.evaluate(_ARRANGE)
        page.locator("body").screenshot(path=out)


if __name__ == "__main__":
    picture(Path(sys.argv[1]), Path(sys.argv[2]))
