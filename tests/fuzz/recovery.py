"""Recordings with flipped bits, wrong blocks, cut ends: `daq recover` keeps what was not hit and states what is lost.

`python -m tests.fuzz.recovery [--count 2000] [--seed 1]`. The bound: the rows that are kept are at least all but
those of the chunks in which a bit was flipped or the file was cut. Nothing is flipped in the first bytes of a file,
which tell what it is.
"""

import argparse
import json
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.reader import make_reader

from daq.program import program
from recordings.container import MAGIC
from recordings.errors import BadInput
from recordings.reader import read
from tests.running import invoke

SAMPLE = Path(__file__).parents[2] / "recordings" / "samples" / "fig5a.mcap"
MAX_FLIPS = 6
CUT = 0.4
"""Share of the files that are cut off."""
BLOCKS = 0.3
"""Share of the files with a block that is not theirs, or lacks."""


@dataclass(frozen=True)
class Piece:
    """A chunk of a recording."""

    start: int
    end: int
    rows: int


def pieces(path: Path) -> list[Piece]:
    """The chunks of a whole recording that hold samples."""
    whole, found = path.read_bytes(), []
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    (channel,) = (each.id for each in summary.channels.values() if each.topic == "/amplifiers")
    for chunk in summary.chunk_indexes:
        if channel in chunk.message_index_offsets:
            at = chunk.message_index_offsets[channel]
            rows = (int.from_bytes(whole[at + 1 : at + 9], "little") - 6) // 16
            start = chunk.chunk_start_offset
            found.append(Piece(start, start + chunk.chunk_length, rows))
    return found


def damaged(whole: bytes, rng: np.random.Generator) -> tuple[bytes, set[int], int]:
    """A file with flipped bits, or cut off, or both, or with a block of zeros, one too much or one too few; where it
    was hit, and where it ends."""
    if rng.random() < BLOCKS:
        at, size = int(rng.integers(len(MAGIC), len(whole))), int(rng.integers(1, 600))
        block = (bytes(size), whole[at : at + size] + b"\x06\xa5\x00" * size, b"")[int(rng.integers(3))]
        return whole[:at] + block + whole[at + size :], set(range(at, at + size)), len(whole)
    spoiled = bytearray(whole)
    end = int(rng.integers(len(MAGIC), len(whole))) if rng.random() < CUT else len(whole)
    flips = int(rng.integers(0 if end < len(whole) else 1, MAX_FLIPS + 1))
    places = {int(place) for place in rng.integers(len(MAGIC), len(whole), flips)}
    for place in places:
        spoiled[place] ^= 1 << int(rng.integers(8))
    return bytes(spoiled[:end]), places, end


def recover_all(count: int, seed: int, folder: Path) -> Counter[str]:
    """Damage and recover the sample `count` times in `folder`; return how often what came out.

    Raises:
        AssertionError: a case misses the bound, or conceals a loss; it is named by seed and number.
    """
    outcomes: Counter[str] = Counter()
    whole, found = SAMPLE.read_bytes(), pieces(SAMPLE)
    for case in range(count):
        spoiled, places, end = damaged(whole, np.random.default_rng((seed, case)))
        hit = {piece for piece in found if piece.end > end or any(piece.start <= at < piece.end for at in places)}
        most = sum(piece.rows for piece in found)
        outcome = recover(spoiled, folder, most, most - sum(piece.rows for piece in hit))
        assert not outcome.startswith("wrong"), f"seed {seed}, case {case}: {outcome}"
        outcomes[outcome] += 1
    return outcomes


def recover(spoiled: bytes, folder: Path, most: int, least: int) -> str:
    """Recover one file, of whose `most` rows at `least` some have to be kept; return what came out."""
    source, out = folder / "spoiled.mcap", folder / "out.mcap"
    source.write_bytes(spoiled)
    out.unlink(missing_ok=True)
    result = invoke(program, "recover", source, "--out", out, "--json")
    if isinstance(result.exception, BadInput):
        if "is whole" in str(result.exception):
            return "whole" if len(read(source).time) == most else "wrong: called whole, but rows are missing"
        return "nothing intact" if least == 0 else f"wrong: {result.exception}"
    if result.exit_code:
        return f"wrong: {result.exception!r}"
    document = json.loads(result.stdout)
    rows, lost = document["rows"], document["lost"]
    if rows < least or lost["rows"] not in (most - rows, None):
        return f"wrong: {least} of {most} rows expected, {rows} kept and {lost['rows']} said to be lost"
    if not (lost["bytes"] or lost["records"] or document["altered"]):
        return "wrong: nothing is said to be lost"
    if "rig" not in lost["records"] and len(read(out).time) != rows:
        return "wrong: the recovered file has other rows"
    return "all rows kept" if rows == most else "rows lost, " + ("stated" if lost["rows"] else "their number unknown")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz.recovery")
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        for what, number in recover_all(options.count, options.seed, Path(scratch)).most_common():
            print(f"{number} of {options.count} files, seed {options.seed}: {what}")
