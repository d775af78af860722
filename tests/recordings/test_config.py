"""Reading TOML: each kind of invalid file gives a one-line error with a remedy."""

from pathlib import Path

import pytest

from recordings.config import ConfigSection, read_toml
from recordings.errors import BadInput

ENDLESS = Path("/dev/zero")


class Inner(ConfigSection):
    size: float = 1.0


class Outer(ConfigSection):
    inner: Inner = Inner()
    pair: tuple[int, int] = (1, 2)


def read(path: Path) -> Outer:
    return read_toml(path, Outer, "test file")


def test_integers_become_floats_and_arrays_become_tuples(tmp_path: Path) -> None:
    path = tmp_path / "t.toml"
    path.write_text("pair = [3, 4]\n[inner]\nsize = 2\n")
    assert read(path) == Outer(inner=Inner(size=2.0), pair=(3, 4))


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"[inner]\nsise = 2\n", "unknown key 'inner.sise'"),
        (b"[inner]\nsize = '2'\n", "'inner.size': .*found '2'"),
        (b"[inner]\nsize = inf\n", r"'inner.size': a number of at most 1e\+12 in size expected, found inf"),
        (b"[inner]\nsize = nan\n", "'inner.size': .*found nan"),
        (b"[inner]\nsize = -1e300\n", r"'inner.size': .*found -1e\+300"),
        (b"pair = [1, 1" + 400 * b"0" + b"]", "'pair.1': .*found a number of many digits"),
        (b"pair = " + 100_000 * b"[", "nested too deeply"),
        (b"pair = [" + 40 * b"[" + 40 * b"]" + b"]", "nested too deeply"),
        (b"#" * 2_000_000, "at most 1000 kB expected"),
        (b"a." * 50_000 + b"a = 1", "keys of at most 16 names"),
        (b"[" + b" 'a b' ." * 50_000 + b" a]", "keys of at most 16 names"),
        (b"pair = [" + b"1" * 10_000 + b", 1]", "not valid TOML.*digits"),
        (b"pair = [1]\n", r"'pair(\.1)?'"),
        (b"pair = [1.5, 'x']\n[inner]\nsise = 1\n", r"\(and 2 more: pair\.0, pair\.1\)"),
        (b"pair = 1979-05-27\n", "'pair'"),
        (b"pair = [", "not valid TOML"),
        (b"name = '\xff'", "cannot be read"),
    ],
)
def test_error_names_file_and_key(tmp_path: Path, content: bytes, reason: str) -> None:
    path = tmp_path / "t.toml"
    path.write_bytes(content)
    with pytest.raises(BadInput, match=reason) as error:
        read(path)
    assert str(error.value).startswith(f"test file {path}")
    assert "\n" not in str(error.value)
    for other, expected in (
        (tmp_path / "none", "does not exist"),
        (tmp_path, "cannot be read"),
        (ENDLESS, "at most"),
    ):
        with pytest.raises(BadInput, match=expected):
            read(other)


def test_descriptions_are_immutable() -> None:
    with pytest.raises(ValueError, match="frozen"):
        Outer().pair = (3, 4)  # type: ignore[misc]
