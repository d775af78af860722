"""Text of EDS and DCF files (CiA 306) as sections, whose fields know their lines."""

import re
from dataclasses import dataclass

_COMMENT = re.compile(r"(?:^|\s);|^\s*(?:#|//)")
_TITLE = re.compile(r"\[([^\]]*)\].*")
_OBJECT = re.compile(r"(?:0x)?([0-9a-f]{4}|[0-9a-f]{2})(?:sub0*([0-9a-f]{1,2}))?")
"""Name of the section of an object; CANFestival gives types of its own two digits."""
_DESCRIBING = ("objecttype", "datatype")
"""Fields that only objects have."""
_DECISIVE = (*_DESCRIBING, "accesstype", "lowlimit", "highlimit", "defaultvalue", "parametervalue", "pdomapping")
"""Fields that may not say two things."""
_LONGEST = 40
"""Characters of a text that an error shows."""
_WORDS = {"YES": "1", "TRUE": "1", "NO": "0", "FALSE": "0"}


@dataclass(frozen=True)
class Section:
    """One section of a file."""

    title: str
    line: int
    fields: dict[str, tuple[str, int]]
    """Value and line by key, in small letters."""

    def text(self, key: str) -> str:
        """Value of a field, empty where there is none."""
        return self.fields.get(key.lower(), ("", 0))[0]

    def number(self, key: str, default: str = "", node_id: int = 0) -> int:
        """The whole number in a field.

        Raises:
            ValueError: there is none, or one such as 010, which may be octal.
        """
        digits, relative = re.subn(r"\+?\$NODEID\+?", "", (self.text(key) or default).replace(" ", "").upper())
        digits = re.sub(r"^([+-]?)0+(\d)$", r"\1\2", digits) or "0" * relative
        try:
            return int(_WORDS.get(digits, digits), 0) + node_id * relative
        except ValueError:
            raise self.wrong(key, "a whole number such as 10 or 0xA") from None

    def wrong(self, key: str, expected: str) -> ValueError:
        """The error of a field: its place, what is expected and found."""
        value, line = self.fields.get(key.lower(), ("", self.line))
        return ValueError(
            f"line {line}, [{self.title}] {key}: {expected} expected, "
            f"{repr(value[:_LONGEST]) if value else 'none'} found"
        )


Sections = dict[tuple[int, int | None] | str, Section]
"""Sections of objects by index and sub-index (None: of the object as a whole), others by name in small letters."""


def divide(text: str) -> Sections:
    """Divide the text of a file; Ctrl-Z ends it, as in DOS. The parts of a section that stands twice become one.

    Raises:
        ValueError: a line, or the name of an object's section, is none; or a field says two things of an object.
    """
    sections: Sections = {}
    section, object_of, name = Section("no section", 1, {}), None, ""
    for line, whole in enumerate(re.split(r"\r\n?|\n", text.partition("\x1a")[0]), start=1):
        content = _COMMENT.split(whole, maxsplit=1)[0].strip()
        if title := _TITLE.fullmatch(content):
            name = "".join(title[1].split()).lower()
            object_of = _OBJECT.fullmatch(name)
            key = (int(object_of[1], 16), int(object_of[2], 16) if object_of[2] else None) if object_of else name
            section = sections.setdefault(key, Section(title[1].strip()[:_LONGEST], line, {}))
        elif len(field := [part.strip() for part in re.split("[=:]", content, maxsplit=1)]) == 2:
            first, place = section.fields.setdefault(field[0].lower(), (field[1], line))
            is_decisive = field[0].lower() in _DECISIVE if object_of else name.endswith("value")
            if is_decisive and first.lower() != field[1].lower():
                raise ValueError(
                    f"line {line}, [{section.title}] {field[0]}: {first[:_LONGEST]!r} as in line {place} expected, "
                    f"{field[1][:_LONGEST]!r} found"
                )
            # Sections such as [M1SubExt6000] are of modules that the device may be given.
            if not object_of and field[0].lower() in _DESCRIBING and not re.match(r"m\d", name):
                raise ValueError(
                    f"line {section.line}: a section such as [6040] or [1018sub1] expected, [{section.title}] found"
                )
        elif content.startswith("[") or (content and object_of):
            raise ValueError(
                f"line {line}, [{section.title}]: KEY=VALUE or [SECTION] expected, {content[:_LONGEST]!r} found"
            )
    return sections
