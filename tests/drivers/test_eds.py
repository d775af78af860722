"""EDS and DCF files, made up and of real drives."""

import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from drivers.eds import load_dictionary
from drivers.simulated.mark import EDS
from recordings.errors import BadInput
from tests.drivers.simulated.dictionaries import I8, I16, MADE_UP, U16, U32, Item, eds

SHARED = Path(os.environ.get("REAL_DATA", Path(__file__).parents[2].parent / "shared" / "data")) / "eds"


def write(folder: Path, text: str, encoding: str = "utf-8") -> Path:
    path = folder / "drive.eds"
    path.write_bytes(text.encode(encoding))
    return path


def test_value_of_a_dcf_replaces_the_default_and_the_node_id_becomes_part_of_cob_ids(tmp_path: Path) -> None:
    path = write(tmp_path, eds({(0x6085, 0): Item(U32, default=1, parameter=77), (0x6040, 0): Item(U16, default=5)}))
    dictionary = load_dictionary(path, 1)
    assert dictionary[0x6085, 0].value == (77).to_bytes(4, "little")
    assert dictionary[0x6040, 0].value == b"\5\0"
    assert dictionary.has_parameters
    defaults = load_dictionary(write(tmp_path, MADE_UP["slow"].eds), 9)
    assert not defaults.has_parameters
    assert defaults[0x1800, 1].value == (0x189).to_bytes(4, "little")


def test_signed_values_and_limits_in_hexadecimal(tmp_path: Path) -> None:
    items = {(0x60C2, 2): Item(I8, default="0xFD", low=-6), (0x605A, 0): Item(I16, default="0xFFFF")}
    dictionary = load_dictionary(write(tmp_path, eds(items)), 1)
    assert dictionary[0x60C2, 2].decode(dictionary[0x60C2, 2].value or b"") == -3
    assert dictionary[0x605A, 0].value == b"\xff\xff"


def test_only_the_sub_indices_of_the_file_exist(tmp_path: Path) -> None:
    compact = "[2002]\nParameterName=a\nObjectType=0x8\nDataType=0x0006\nAccessType=rw\nCompactSubObj=3\n"
    dictionary = load_dictionary(write(tmp_path, eds({(0x1016, 1): Item(U32)}) + compact), 1)
    assert sorted(dictionary) == [(0x1016, 0), (0x1016, 1), *((0x2002, sub) for sub in range(4))]


def test_entries_of_a_compact_array_have_their_values_limits_and_names(tmp_path: Path) -> None:
    array = "[2002]\nParameterName=a\nObjectType=0x8\nDataType=0x0004\nAccessType=rw\nLowLimit=-9\nDefaultValue=7\n"
    array += "PDOMapping=1\nCompactSubObj=3\n[2002Name]\nNrOfEntries=2\n1=low\n2=high\n"
    assert not load_dictionary(write(tmp_path, eds({}) + array), 1).has_parameters
    dictionary = load_dictionary(write(tmp_path, eds({}) + array + "[2002Value]\nNrOfEntries=1\n2=-5\n"), 1)
    entries = [dictionary[0x2002, sub] for sub in (1, 2, 3)]
    assert [entry.decode(entry.value or b"") for entry in entries] == [7, -5, 7]
    assert {(entry.low, entry.mappable) for entry in entries} == {(-9, True)}
    assert [entry.is_parameter for entry in entries] == [False, True, False]
    assert [entry.name for entry in entries] == ["low", "high", "a"]


def test_an_entry_that_a_file_describes_itself_stays(tmp_path: Path) -> None:
    array = "[2002]\nParameterName=a\nObjectType=0x8\nDataType=0x0004\nAccessType=rw\nLowLimit=-9\nCompactSubObj=2\n"
    own = "[2002Sub2]\nParameterName=b\nObjectType=0x7\nDataType=0x0004\nAccessType=rw\nLowLimit=-3\n"
    dictionary = load_dictionary(write(tmp_path, eds({}) + array + own), 1)
    assert [dictionary[0x2002, sub].low for sub in (1, 2)] == [-9, -3]


def test_files_of_other_encodings_are_read(tmp_path: Path) -> None:
    path = write(tmp_path, eds({(0x6041, 0): Item(U16)}, name="Gerät für Säge"), encoding="latin-1")
    assert load_dictionary(path, 1).name == "Gerät für Säge"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "no object"),
        ("not an EDS", "no object"),
        ("[1000]\nParameterName=a\n", r"line 1, \[1000\] DataType: a whole number .* expected, none found"),
        ("[1000sub1]\nDataType=7\n", r"line 1, \[1000sub1\] AccessType: one of ro, .* expected, none found"),
    ],
)
def test_what_is_no_dictionary_is_refused(text: str, reason: str, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"^EDS or DCF \S*drive\.eds does not exist; check the path$"):
        load_dictionary(tmp_path / "drive.eds", 1)
    with pytest.raises(BadInput, match=reason) as refused:
        load_dictionary(write(tmp_path, text), 1)
    assert "\n" not in str(refused.value)


PLAIN = EDS.read_text(encoding="utf-8")


def replaced(*pairs: tuple[str, str]) -> Callable[[str], str]:
    def change(text: str) -> str:
        for old, new in pairs:
            assert old in text
            text = text.replace(old, new)
        return text

    return change


def added(end: str) -> Callable[[str], str]:
    return lambda text: text + "\n" + end


def spelled(spell: Callable[[str], str]) -> Callable[[str], str]:
    """Change the capitals of sections and keys."""
    return lambda text: re.sub(r"^(\[.*\]|[^=\n]+(?==))", lambda match: spell(match[0]), text, flags=re.MULTILINE)


SAME: dict[str, Callable[[str], str]] = {
    "comments with small letters": added("[Comments]\nLines=2\nLine1=Data sheet\nline2=second line\n"),
    "comments with gaps": added("[comments]\nLines=0x9\nLine 1=a\nLINE7=b\nwithout a key\n"),
    "comments without a number": added("[Comments]\nLines=\n"),
    "lines of comments": replaced(("DefaultValue=4\n", "DefaultValue=4 ; four\n;a\n  ;b\n#c\n// d=e\n")),
    "vendor 001": replaced(("VendorNumber=0\n", "VendorNumber=001\n")),
    "odd device information": replaced(
        ("LSS_Supported=0", "LSS_Supported="), ("Granularity=8", "Granularity=8 bit"), ("NrOfRXPDO=1", "NrOfRXPDO")
    ),
    "bit rates in words": replaced(
        ("BaudRate_500=1", "BaudRate_500=yes"), ("BaudRate_10=0", "BaudRate_10=no"), ("BaudRate_20=0", "BaudRate_20=")
    ),
    "a short list of dummies": replaced(("Dummy0007=0\n", "")),
    "no dummies": replaced(("[DummyUsage]\n", "")),
    "odd dummies": replaced(("Dummy0003=0\n", "Dummy0003=\nDummy0010=x\n")),
    "DOS": lambda text: text.replace("\n", "\r\n") + "\x1a",
    "a rest behind Ctrl-Z": lambda text: text + "\x1a\0\0[6040]\nDataType=x",
    "Macintosh": lambda text: text.replace("\n", "\r"),
    "small letters": spelled(str.lower),
    "capitals": spelled(str.upper),
    "blanks": replaced(("[1018sub1]\n", "  [ 1018 Sub 1 ]  \n"), ("ParameterName=", "  ParameterName = ")),
    "zeros before a sub-index": replaced(("[1018sub1]", "[1018sub01]")),
    "numbers of any kind": replaced(("DataType=0x0007", "DataType=07"), ("ObjectType=0x9", "ObjectType=9")),
    "lists that name others": replaced(("3=0x1018\n", "3=0x1019\n"), ("SupportedObjects=3", "SupportedObjects=x")),
    "a record without its section": replaced(("[1018]\nParameterName=Identity object\nObjectType=0x9\n", "[Gone]\n")),
    "a record without its type": replaced(("Identity object\nObjectType=0x9\n", "Identity object\n")),
    "wrong numbers of sub-indices": replaced(("SubNumber=5", "SubNumber=a few"), ("SubNumber=2\n", "")),
    "a section in two parts": replaced(("[1018sub0]", "[1018sub1]\nAccessType=ro\n[1018sub0]")),
    "a section and a key twice": replaced(("[1018sub0]", "[1018SUB1]\nObjectType=0X7\nDefaultValue=0\n[1018sub0]")),
    "words in the file information": replaced(("FileVersion=1\n", "FileVersion=-\nsome weird text\n")),
    "a preamble": lambda text: "\N{BYTE ORDER MARK}made by a tool\n" + text,
    "modules": added("[M1ModuleInfo]\nOrderCode=x\n[M1SubExt6000]\nObjectType=0x7\nDataType=x\n"),
}


@pytest.mark.parametrize("name", SAME)
def test_what_no_object_needs_may_stand_as_it_likes(name: str, tmp_path: Path) -> None:
    changed = SAME[name](PLAIN)
    assert changed != PLAIN
    path = tmp_path / "drive.eds"
    path.write_bytes(changed.encode())
    assert load_dictionary(path, 5) == load_dictionary(EDS, 5)


def test_fields_that_say_nothing_have_their_defaults(tmp_path: Path) -> None:
    text = "[6040]\nDataType=0x0006\nAccessType=RWW\nDefaultValue=\nLowLimit= ;none\nPDOMapping=\nObjectType=\n"
    text += "[1010]\nObjectType=2\n[2000]\nDataType=0x8\nAccessType=ro\nDefaultValue=0x41200000\nHighLimit=1.5\n"
    text += "[2001]\nDataType=1\nAccessType=ro\nDefaultValue=TRUE\n"
    text += "[100B]\nDataType=7\nAccessType=ro\nDefaultValue=$NODEID\n"
    dictionary = load_dictionary(write(tmp_path, text), 5)
    control, domain = dictionary[0x6040, 0], dictionary[0x1010, 0]
    assert (control.name, control.access, control.value, control.low, control.mappable) == (
        "",
        "rww",
        None,
        None,
        False,
    )
    assert (domain.data_type, domain.access, domain.size) == (0xF, "rw", None)
    assert (dictionary[0x2000, 0].value, dictionary[0x2000, 0].high) == (None, None)
    assert (dictionary[0x2001, 0].value, dictionary[0x100B, 0].value) == (b"\1", b"\5\0\0\0")
    assert (dictionary.name, dictionary.bit_rates) == ("drive", frozenset())


def test_types_of_canfestival_and_unknown_types(tmp_path: Path) -> None:
    own = "[A0]\nObjectType=0x7\n[A0sub1]\nDataType=0x0007\nAccessType=ro\nDefaultValue=0x0003\n"
    text = own + "[2000]\nDataType=0xA0\nAccessType=rw\nDefaultValue=-2\n[2001]\nDataType=0x21\nAccessType=rw\n"
    dictionary = load_dictionary(write(tmp_path, text), 5)
    assert dictionary[0x2000, 0].value == b"\xfe\xff"
    assert dictionary[0x2001, 0].size is None


WRONG = [
    ("1018sub1", "DataType", "UNSIGNED32", "a whole number such as 10 or 0xA"),
    ("1018sub1", "DataType", "010", "a whole number such as 10 or 0xA"),
    ("1018sub1", "DataType", "0", "the index of a data type, such as 0x0007,"),
    ("1018sub1", "DataType", "0x10007", "the index of a data type, such as 0x0007,"),
    ("1018sub1", "AccessType", "readwrite", "one of ro, wo, rw, rwr, rww, const"),
    ("1018", "ObjectType", "RECORD", "a whole number such as 10 or 0xA"),
    ("1018", "ObjectType", "0x17", "7 (VAR), 8 (ARRAY), 9 (RECORD) or 2 (DOMAIN)"),
    ("1018sub2", "DefaultValue", "1,5", "a whole number such as 10 or 0xA"),
    ("1018sub2", "DefaultValue", "0xGG", "a whole number such as 10 or 0xA"),
    ("1018sub2", "ParameterValue", "$NODE+1", "a whole number such as 10 or 0xA"),
    ("1018sub2", "LowLimit", "none", "a whole number such as 10 or 0xA"),
    ("1018sub2", "HighLimit", "4294967295.0", "a whole number such as 10 or 0xA"),
    ("1018sub2", "PDOMapping", "maybe", "a whole number such as 10 or 0xA"),
    ("1018", "CompactSubObj", "four", "a whole number such as 10 or 0xA"),
    ("6040", "defaultvalue", "five", "a whole number such as 10 or 0xA"),
]


@pytest.mark.parametrize(("section", "key", "value", "expected"), WRONG)
def test_what_an_object_needs_is_named_by_section_key_and_line(
    section: str, key: str, value: str, expected: str, tmp_path: Path
) -> None:
    lines = PLAIN.splitlines()
    first = lines.index(f"[{section}]") + 1
    last = lines.index("", first)
    old = [k for k in range(first, last) if lines[k].lower().startswith(f"{key.lower()}=")]
    lines[old[0] if old else first : old[0] + 1 if old else first] = [f"{key}={value}"]
    line = (old[0] if old else first) + 1
    with pytest.raises(BadInput) as refused:
        load_dictionary(write(tmp_path, "\n".join(lines)), 5)
    where = f"{tmp_path / 'drive.eds'}, line {line}, [{section}] "
    assert (
        str(refused.value).lower() == f"{where}{key}: {expected} expected, {value!r} found; correct the file".lower()
    )


OBJECT = "[6040]\nDataType=6\nAccessType=rw\n"
REFUSED = {
    "a key that says two things": (
        OBJECT + "DataType=7\n",
        "line 4, [6040] DataType: '6' as in line 2 expected, '7' found",
    ),
    "a section that says two things": (
        OBJECT + "[x]\n[6040]\nAccessType=ro\n",
        "line 6, [6040] AccessType: 'rw' as in line 3 expected, 'ro' found",
    ),
    "a value of a compact array that is two": (
        "[2000Value]\n1=5\n1=6\n",
        "line 3, [2000Value] 1: '5' as in line 2 expected, '6' found",
    ),
    "an index that is none": (
        "[604G]\nDataType=6\n",
        "line 1: a section such as [6040] or [1018sub1] expected, [604G]",
    ),
    "a digit too few": (
        "\n[604]\nObjectType=7\n",
        "line 2: a section such as [6040] or [1018sub1] expected, [604] found",
    ),
    "a sub-index too large": ("[6040sub100]\nDataType=6\n", "[6040sub100] found"),
    "no object of a value": ("[DeviceInfo]\nObjectType=7\n", "[DeviceInfo] found"),
    "an open bracket at first": (
        "[6040\nDataType=6\n",
        "line 1, [no section]: KEY=VALUE or [SECTION] expected, '[6040'",
    ),
    "an open bracket": ("[FileInfo]\n[6040\n", "line 2, [FileInfo]: KEY=VALUE or [SECTION] expected, '[6040' found"),
    "a line without a value": (
        OBJECT + "DefaultValue 5\n",
        "line 4, [6040]: KEY=VALUE or [SECTION] expected, 'Default",
    ),
    "a real": (
        OBJECT.replace("6\n", "8\n") + "HighLimit=ten\n",
        "line 4, [6040] HighLimit: a whole number such as 10",
    ),
    "a missing type": (
        OBJECT + "[6041]\nAccessType=ro\n",
        "line 4, [6041] DataType: a whole number such as 10 or 0xA",
    ),
    "a value of a compact array": (
        "[2000]\nDataType=4\nAccessType=rw\nObjectType=8\nCompactSubObj=2\n[2000Value]\n2=x\n",
        "line 7, [2000] ParameterValue: a whole number such as 10 or 0xA expected, 'x' found",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_no_object_can_be_is_refused(name: str, tmp_path: Path) -> None:
    text, reason = REFUSED[name]
    with pytest.raises(BadInput) as refused:
        load_dictionary(write(tmp_path, text), 1)
    assert reason in str(refused.value)
    assert str(refused.value).endswith("; correct the file")


def test_a_variable_beside_sub_indices_stays(tmp_path: Path) -> None:
    assert set(load_dictionary(write(tmp_path, OBJECT + OBJECT.replace("6040", "6040sub1")), 1)) == {
        (0x6040, 0),
        (0x6040, 1),
    }


def test_every_value_has_the_length_of_its_type(tmp_path: Path) -> None:
    files = [EDS, *sorted(SHARED.glob("*.eds")), *sorted(SHARED.glob("*.dcf"))]
    for path in files:
        for entry in load_dictionary(path, 5).values():
            assert entry.value is None or entry.size in (None, len(entry.value))
