"""Debian's browser, driven by Playwright."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from tests.patience import patient

PATIENCE = patient(120)
"""Longest time that a page may take on a busy machine [s]."""


@contextmanager
def tab() -> Iterator[Any]:
    """Open an empty tab. Without a browser the test is skipped; on CI it fails."""
    path = shutil.which("chromium")
    if path is None:
        if os.environ.get("CI") == "true":
            pytest.fail("chromium expected on CI, none found; apt-get install chromium")
        pytest.skip("needs Debian's chromium")
    from playwright.sync_api import sync_playwright

    flags = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=flags)
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.set_default_timeout(1e3 * PATIENCE)
        yield page
        if not page.is_closed():
            print(page.inner_text("body"))  # what a test that failed saw
        browser.close()
