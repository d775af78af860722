"""`python -m benchmarks.fleet FOLDER --robots 3 --nights 12 --seed 1`."""

import json
import subprocess
import sys
import time
from pathlib import Path

import click

from benchmarks.fleet import plan, record
from benchmarks.fleet.scoring import Score, score, smallest_in
from drivers.simulated.seal import unseal
from recordings.progress import progress_bar

_OPEN = 3
"""Exit code of `ident fleet` with open alarms."""


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--robots", default=3, show_default=True, type=click.IntRange(1))
@click.option("--nights", default=12, show_default=True, type=click.IntRange(1))
@click.option("--events", type=click.IntRange(0), help="Hidden events.  [default: half as many as robots]")
@click.option("--outside", is_flag=True, help="Hide effects that no library has: alarms have to be of unknown ones.")
@click.option("--seed", default=1, show_default=True, type=click.IntRange(0))
@click.option("--engine", help="As in ident fleet.")
@click.option("--strict", is_flag=True, help="Fail unless all events are right, and no alarm is false.")
@click.option("--only-make", is_flag=True, help="Make the recordings and no more.")
def main(
    folder: Path,
    robots: int,
    nights: int,
    events: int | None,
    outside: bool,
    seed: int,
    engine: str | None,
    strict: bool,
    only_make: bool,
) -> None:
    """Make a fleet in FOLDER/recordings, watch it, and score the alarms against the truth."""
    drawn = plan.draw(seed, robots, nights, robots // 2 if events is None else events, outside)
    recordings, store = folder / "recordings", folder / "store"
    with progress_bar("recording") as show:
        record.make(recordings, drawn, lambda done, total: show("recording", done, total))
    if only_make:
        return
    begin = time.monotonic()
    options = ["--engine", engine] if engine else []
    command = ["fleet", str(recordings), "--store", str(store), "--json", *options]
    done = subprocess.run(
        [sys.executable, "-c", "from ident.cli import main; main()", *command], stdout=subprocess.PIPE, text=True
    )
    if done.returncode not in (0, _OPEN):
        sys.exit(done.returncode)
    document = json.loads(done.stdout)
    seconds = time.monotonic() - begin
    scores, false = score(unseal(recordings / record.SEALED), document["alarms"], smallest_in(recordings))
    _print(document, scores, false)
    print(f"{document['recordings']['new']} new recordings in {seconds:.0f} s")
    if strict and (false or not all(entry.right for entry in scores)):
        sys.exit(1)


def _print(document: dict[str, object], scores: list[Score], false: list[dict[str, object]]) -> None:
    for entry in scores:
        event = entry.event
        kind = "growing" if event["growing"] else "sudden"
        print(
            f"{event['robot']} joint {event['joint']} {event['effect']} {kind} since {event['since']}: {_say(entry)}"
        )
    for alarm in false:
        print(f"false alarm: {alarm['robot']} {alarm['effect']} on joints {alarm['joints']} since {alarm['since']}")
    right = sum(entry.right for entry in scores)
    print(f"{right} of {len(scores)} events right, {len(false)} false alarms; recordings {document['recordings']}")


def _say(entry: Score) -> str:
    if not entry.raised:
        return "missed"
    wrong = [name for name in ("named", "joint", "dated") if not getattr(entry, name)]
    return f"{'wrong: ' + ', '.join(wrong) if wrong else 'right'}, {entry.nights_off:+d} nights"


if __name__ == "__main__":
    main()
