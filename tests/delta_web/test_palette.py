"""One palette: a colour has one meaning, on every page and in every picture."""

import re
from pathlib import Path

import delta_web
from delta_web.palette import CATEGORIES, JOINTS, MEASURED, NOISE

ROOT = Path(delta_web.__path__[0]).parent
COLOURS = {colour.lower() for colour in (*JOINTS, NOISE, MEASURED, *CATEGORIES)}


def test_no_two_meanings_share_a_colour() -> None:
    assert len(COLOURS) == len(JOINTS) + 2 + len(CATEGORIES)


def test_no_module_writes_a_colour_of_the_palette_itself() -> None:
    modules = [path for room in ("daq", "ident", "trajectories", "delta_web") for path in (ROOT / room).rglob("*.py")]
    copies = {
        path.relative_to(ROOT).as_posix()
        for path in modules
        if COLOURS & set(re.findall(r"#[0-9a-f]{6}", path.read_text(encoding="utf-8").lower()))
    }
    assert copies == {"delta_web/palette.py"}
