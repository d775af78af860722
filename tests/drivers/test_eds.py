"""EDS and DCF files, made up and of real drives."""

import os
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
        ("not an EDS", "no section headers"),
        ("[1000]\nParameterName=a\n", "DataType"),
        ("[1000sub1]\nParameterName=a\n", "not found in Object Dictionary"),
        ("[6040]\nParameterName=a\nDataType=x\nAccessType=rw\n", "invalid literal"),
    ],
)
def test_what_is_no_dictionary_is_refused(text: str, reason: str, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"^EDS or DCF \S*drive\.eds does not exist; check the path$"):
        load_dictionary(tmp_path / "drive.eds", 1)
    with pytest.raises(BadInput, match=reason) as refused:
        load_dictionary(write(tmp_path, text), 1)
    assert "\n" not in str(refused.value)


def test_every_value_has_the_length_of_its_type(tmp_path: Path) -> None:
    files = [EDS, *sorted(SHARED.glob("*.eds")), *sorted(SHARED.glob("*.dcf"))]
    for path in files:
        for entry in load_dictionary(path, 5).values():
            assert entry.value is None or entry.size in (None, len(entry.value))
