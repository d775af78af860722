"""Script that draws figures with several plots on narrow pages."""

import importlib.resources


def javascript() -> str:
    """Return JavaScript that defines `figuresOnNarrowPages`, for a page with Plotly."""
    file = importlib.resources.files("ident.output.figures") / "narrow.js"
    return file.read_text(encoding="utf-8")
