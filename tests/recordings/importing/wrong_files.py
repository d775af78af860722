"""Files with which `daq import` and the commands after it are tried: each is wrong in one way."""

import os
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pyarrow
from pyarrow import parquet

TABLE = "time,position_1,voltage_1\n" + "".join(f"{0.01 * k:.2f},{np.sin(0.3 * k):.4f},{k % 5}\n" for k in range(40))
SCOPE = "t [ms];q1 [deg];i1 [A];state\n" + "".join(f"{10 * k};{k % 7},5;{k % 3},25;run\n" for k in range(40))
RIG = 'name = "two"\nmechanism = "axes"\n[[axes]]\n[[axes]]\n'


def efforts(rows: Iterable[str]) -> str:
    return "\n".join(("time,position_1,effort_1", *rows)) + "\n"


def joints(*names: str) -> str:
    """Positions and efforts of the joints, whose names are put in."""
    columns = [name.format(quantity) for quantity in ("position", "effort") for name in names]
    rows = (",".join(f"{np.sin(0.1 * k + i):.4f}" for i in range(len(columns))) for k in range(40))
    return "\n".join((",".join(["time", *columns]), *(f"{0.01 * k:.2f},{row}" for k, row in enumerate(rows)))) + "\n"


FILES: dict[str, Callable[[Path], object]] = {
    "table.csv": lambda path: path.write_text(TABLE),
    "scope.csv": lambda path: path.write_text(SCOPE),
    "two.toml": lambda path: path.write_text(RIG),
    "broken.toml": lambda path: path.write_text("name = "),
    "list.toml": lambda path: path.write_text("position_1 = 3"),
    "empty.csv": lambda path: path.touch(),
    "letter.mcap": lambda path: path.write_text("hello world, this is no recording\n" * 20),
    "header.csv": lambda path: path.write_text(TABLE.splitlines()[0] + "\n"),
    "short-row.csv": lambda path: path.write_text(TABLE.replace("0.05,", "", 1)),
    "text-cell.csv": lambda path: path.write_text(TABLE.replace("0.05,", "0.05,oops", 1)),
    "infinite.csv": lambda path: path.write_text(TABLE.replace("0.05,", "0.05,inf,0\n0.055,", 1)),
    "late.csv": lambda path: path.write_text(TABLE.replace("0.39,", "1e10,", 1)),
    "two-times.csv": lambda path: path.write_text(TABLE.replace("0.06,", "0.05,", 1)),
    "no-time.csv": lambda path: path.write_text(TABLE.replace("0.06,", ",", 1)),
    "twice.csv": lambda path: path.write_text(TABLE.replace("voltage_1", "position_1", 1)),
    "gap.csv": lambda path: path.write_text(TABLE.replace("position_1", "position_2", 1)),
    "half-cycle.csv": lambda path: path.write_text("cycle," + TABLE.replace("\n0", "\n0.5,0")),
    "no-drive.csv": lambda path: path.write_text(TABLE.replace("voltage_1", "volts", 1)),
    "rest.csv": lambda path: path.write_text(efforts(f"{k / 100},1,{k}" for k in range(40))),
    "slow.csv": lambda path: path.write_text(efforts(f"{2 * k},{k % 5},{k}" for k in range(400))),
    "constant.csv": lambda path: path.write_text(efforts(f"{k / 100},{k % 9},1" for k in range(400))),
    "huge-angle.csv": lambda path: path.write_text(efforts(f"{k},{1e160 if k == 8 else k},1" for k in range(40))),
    "six.csv": lambda path: path.write_text(joints(*(f"{{}}_{k}" for k in range(1, 7)))),
    "arm.csv": lambda path: path.write_text(joints("elbow_{}", "wrist_1_{}", "wrist_2_{}", "wrist_3_{}")),
    "deep.json": lambda path: path.write_text(10_000 * "[" + 10_000 * "]"),
    "photo.jpg": lambda path: path.write_bytes(b"\xff\xd8\xff\xe0\x00\x10JFIF" + bytes(100)),
    "report.pdf": lambda path: path.write_bytes(b"%PDF-1.7\n1 0 obj\n"),
    "book.xlsx": lambda path: path.write_bytes(b"PK\x03\x04" + bytes(26) + b"xl/workbook.xml"),
    "binary.dat": lambda path: path.write_bytes(bytes(range(256)) * 4),
    "half.parquet": lambda path: (parquet.write_table(pyarrow.table({"t": [1.0]}), path), os.truncate(path, 60)),
    "uneven.npz": lambda path: np.savez(path, time=np.arange(9.0), position=np.zeros(8), effort=np.zeros(9)),
    "complex.npz": lambda path: np.savez(path, time=np.arange(9.0), position=np.full((9, 1), 1j), effort=np.zeros(9)),
    "cube.npz": lambda path: np.savez(path, q=np.zeros((3, 3, 3)), Ts=0.1),
    "half.db3": lambda path: path.write_bytes(b"SQLite format 3\0" + bytes(100)),
    "bag.zip": lambda path: path.write_bytes(b"PK\x03\x04" + bytes(100)),
    "bag/metadata.yaml": lambda path: (path.parent.mkdir(), path.write_text("rosbag2_bagfile_information: {}")),
    "folder/x": lambda path: (path.parent.mkdir(), path.touch()),
    "there.mcap": lambda path: path.write_text("precious"),
}  # fmt: skip
