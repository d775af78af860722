"""Debian's browser, driven by Playwright."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

PATIENCE = 300.0
"""How long a page may take to show what it is waited for, on a busy machine [s]."""


@contextmanager
def tab() -> Iterator[Any]:
    """An empty tab. The test is skipped where there is no browser, except on CI, where a missing one is a failure."""
    matches = shutil.which("chromium")
    if matches is None:
        if os.environ.get("CI") == "true":
            pytest.fail("chromium expected on CI, none found; apt-get install chromium")
        pytest.skip("needs Debian's chromium")
    from playwright.sync_api import sync_playwright

    flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=matches, args=flags)
        page = launched.new_page(viewport={"width": 1280, "height": 800})
        page.set_default_timeout(1e3 * PATIENCE)
        yield page
        launched.close()
