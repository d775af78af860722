"""Kinds of files that hold no measurements as a table, named for a person."""

from pathlib import Path

_SHEET = "save its sheet as CSV"
_UNPACK = "unpack it, and import the file in it"
_KINDS: tuple[tuple[bytes, str, str], ...] = (
    (b"\xff\xd8\xff", "a JPEG picture", ""),
    (b"\x89PNG", "a PNG picture", ""),
    (b"GIF8", "a GIF picture", ""),
    (b"%PDF", "a PDF document", ""),
    (b"\xd0\xcf\x11\xe0", "an old Excel or Word document", _SHEET),
    (b"\x1f\x8b", "a gzip archive", _UNPACK),
    (b"BZh9", "a bzip2 archive", _UNPACK),
    (b"\xfd7zXZ\0", "an xz archive", _UNPACK),
    (b"7z\xbc\xaf", "a 7z archive", _UNPACK),
    (b"Rar!", "a RAR archive", _UNPACK),
    (b"(\xb5/\xfd", "a Zstandard archive", _UNPACK),
    (b"\x93NUMPY", "a single NumPy array", "save the arrays by their names with numpy.savez"),
    (b"\x80\x04", "a Python pickle, which is never opened", "save the arrays with numpy.savez"),
    (b"\x80\x05", "a Python pickle, which is never opened", "save the arrays with numpy.savez"),
    (b"\x7fELF", "a program", ""),
    (b"<?xml", "an XML document", ""),
    (b"<!DOCTYPE", "a web page", ""),
    (b"<html", "a web page", ""),
    (b"{", "a JSON document", ""),
    (b"[{", "a JSON document", ""),
)
"""First bytes, kind, and what to do; empty: as with `_OTHER`."""
_OTHER = "give the file of the measurements, or export it as CSV"

_ZIPPED = ((b"xl/", "an Excel workbook"), (b"opendocument", "an OpenDocument file"), (b"word/", "a Word document"))
"""What a ZIP file holds, and its kind."""


def kind_of(path: Path, head: bytes) -> tuple[str, str] | None:
    """Kind of a file that begins with `head`, or of a folder, and what to do; None for what may be a table."""
    if path.is_dir():
        return "a folder that is no bag", "name a file in it"
    if head.startswith(b"PK\x03\x04"):
        with path.open("rb") as stream:
            content = stream.read(1 << 16)
        kind = next((kind for mark, kind in _ZIPPED if mark in content), None)
        return (kind, _SHEET) if kind else ("a ZIP archive", _UNPACK)
    for magic, kind, remedy in _KINDS:
        if head.startswith(magic):
            return kind, remedy or _OTHER
    if b"\0" in head and not head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "binary data of an unknown kind", _OTHER
    return None
