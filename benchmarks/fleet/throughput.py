"""What an engine costs: recordings per second of plain processes and of Dask, side by side, and trivial items.

`python -m benchmarks.fleet.throughput FOLDER` analyses the recordings in FOLDER, which it makes where there are none,
with one and two plain processes, with as many local Dask workers, and with two workers that joined a scheduler over
TCP. They take turns, and each second round is in reverse order, so that a machine that becomes slower favours none. A
rate is counted from the first results on, so that nobody's start-up is in it, and by the instants at which workers
finish: Dask returns several results at a time.
"""

import multiprocessing
import os
import resource
import statistics
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import click

from benchmarks.fleet import cluster, plan, record
from benchmarks.programs import ratio
from ident.fleet import engines
from ident.fleet.engines import ONE_THREAD, EngineOptions
from ident.fleet.recording_rows import examine
from ident.fleet.settings import FleetSettings
from ident.fleet.walk import RecordingFile, walk
from recordings.errors import BadInput

_TRIVIAL = 10_000
_WARM_UP = 0.1
"""Share of the first results that are not counted."""
_PAIRS = (("dask 1", "plain 1"), ("dask 2", "plain 2"), ("tcp 2", "plain 2"))
_MADE_ROBOTS = 5
_ROBOTS = 1000
_SECONDS_A_NIGHT = 3600 * 8
_MIB = 1024.0


class Analysis(NamedTuple):
    """What a worker says of a recording."""

    end: float
    """Instant at which it was analysed, by the clock of this machine [s]."""
    memory: float
    """Peak memory of the worker until then [MiB]."""


def analysed(file: RecordingFile) -> Analysis:
    """Analyse a recording."""
    examine(file, FleetSettings())
    return Analysis(time.monotonic(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / _MIB)


def trivial(number: int) -> int:
    """Return what was given."""
    return number


def _dask(files: Sequence[RecordingFile], options: EngineOptions) -> Iterator[Analysis]:
    return (result for _, result in engines.load("dask").run(analysed, files, options) if result)


def _joined(files: Sequence[RecordingFile], workers: int) -> Iterator[Analysis]:
    """Workers are started anew, as those of the other ways are."""
    with cluster.started(workers) as joined:
        yield from _dask(files, joined.options)


def _plain(files: Sequence[RecordingFile], workers: int) -> Iterator[Analysis]:
    """Each of so many processes takes the next file from a queue: nothing but the work itself."""
    context = multiprocessing.get_context("spawn")
    waiting, results = context.Queue(), context.Queue()
    for file in [*files, *[None] * workers]:
        waiting.put(file)
    processes = [context.Process(target=_work, args=(waiting, results)) for _ in range(workers)]
    for process in processes:
        process.start()
    for _ in files:
        yield results.get()
    for process in processes:
        process.join()


def _work(waiting: "multiprocessing.Queue[RecordingFile | None]", results: "multiprocessing.Queue[Analysis]") -> None:
    while (file := waiting.get()) is not None:
        results.put(engines.alone(analysed, file))


_WAYS: dict[str, Callable[[Sequence[RecordingFile]], Iterator[Analysis]]] = {
    "plain 1": lambda files: _plain(files, 1),
    "dask 1": lambda files: _dask(files, EngineOptions(1)),
    "dask 2": lambda files: _dask(files, EngineOptions(2)),
    "plain 2": lambda files: _plain(files, 2),
    "tcp 2": lambda files: _joined(files, 2),
}


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--recordings", "count", default=100, show_default=True, type=click.IntRange(10))
@click.option("--repeats", default=3, show_default=True, type=click.IntRange(1))
@click.option("--trivial", "items", default=_TRIVIAL, show_default=True, type=click.IntRange(10))
def main(folder: Path, count: int, repeats: int, items: int) -> None:
    """Print rates, their ratios in paired runs, the overhead for each item, and what a large fleet needs."""
    files = _recordings(folder, count)
    rates: dict[str, list[float]] = {}
    memory = 0.0
    for round_number in range(repeats):
        for name, run in list(_WAYS.items())[:: -1 if round_number % 2 else 1]:
            analyses = list(run(files))
            rates.setdefault(name, []).append(rate := _rate([analysis.end for analysis in analyses]))
            memory = max(memory, *(analysis.memory for analysis in analyses))
            print(f"{name}: {rate:.2f} recordings/s", flush=True)
    for name, plain in _PAIRS:
        print(f"{name} / {plain}: {ratio(rates[name], rates[plain])}")
    print(f"peak memory of a worker: {memory:.0f} MiB")
    _overhead(items)
    print(_needs({1: statistics.median(rates["dask 1"]), 2: statistics.median(rates["tcp 2"])}))


def _recordings(folder: Path, count: int) -> list[RecordingFile]:
    """The first `count` recordings below `folder`; they are made if it does not exist, or not all were made."""
    nights = -(-count // _MADE_ROBOTS)
    drawn = replace(plan.draw(1, _MADE_ROBOTS, nights, events=0), missing=frozenset(), faults={})
    if not folder.exists() or (folder / record.name(0)).is_dir():
        record.make(folder, drawn)
    files = list(walk([folder]))[:count]
    if len(files) < count:
        raise BadInput(f"{folder}: {count} recordings expected, {len(files)} found; name a new folder to make them")
    return files


def _rate(ends: Sequence[float]) -> float:
    """Results per second after the first ones.

    ends: instants at which they were finished, in any order [s].
    """
    ends = sorted(ends)
    first = max(int(_WARM_UP * len(ends)), 2)
    return (len(ends) - first) / (ends[-1] - ends[first - 1])


def _overhead(items: int) -> None:
    begin = time.monotonic()
    results = engines.load("dask").run(trivial, range(items), EngineOptions(2))
    next(results)
    start, cpu = time.monotonic(), time.process_time()
    assert sum(1 for _ in results) == items - 1
    seconds, cpu = time.monotonic() - start, time.process_time() - cpu
    print(f"{items} trivial items: {1000 * seconds / items:.2f} ms each, start-up {start - begin:.1f} s")
    print(f"of them {1000 * cpu / items:.2f} ms computing in this process")


def _needs(rates: Mapping[int, float]) -> str:
    """What a night of many robots needs, as a table.

    rates: recordings per second by the number of workers; the largest number is that of one machine.
    """
    machine = max(rates)
    workers = {**rates, **{machine * machines: rates[machine] * machines for machines in (2, 4, 8)}}
    lines = [
        f"{_ROBOTS:,} robots, one recording each:",
        "| workers | recordings per second | time | robots in a night of 8 h |",
        "|---|---|---|---|",
    ]
    for number, rate in workers.items():
        robots = f"{_SECONDS_A_NIGHT * rate:,.0f}"
        lines.append(f"| {number} | {rate:.2f} | {_ROBOTS / rate / 60:.1f} min | {robots} |")
    return "\n".join(lines)


if __name__ == "__main__":
    os.environ.update(ONE_THREAD)  # of all processes that are started here, plain or not
    main()
