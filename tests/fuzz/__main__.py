"""`make fuzz`: feed 100,000 inputs of each kind; print the number of refused inputs and the growth of memory."""

import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from tests.fuzz import inputs

COUNT = 100_000


def megabytes() -> float:
    """Peak memory of this process [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def campaign(name: str, run: Callable[[int], int]) -> None:
    """Run one kind of input after a warm-up and measure the growth of memory."""
    run(COUNT // 10)
    before, began = megabytes(), time.perf_counter()
    refused = run(COUNT)
    seconds = time.perf_counter() - began
    print(f"{name}: {COUNT:,} inputs in {seconds:.0f} s, {refused:,} noticed, memory +{megabytes() - before:.1f} MB")


with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    sample = inputs.small_recording(folder / "sample.mcap")
    campaign("CAN frames to the driver", lambda count: inputs.frames_to_the_driver(count, 1))
    campaign("CAN frames to a simulated drive", lambda count: inputs.frames_to_a_drive(count, 2))
    campaign("serial replies", lambda count: inputs.serial_replies(count, 3))
    campaign("recordings", lambda count: inputs.files(count, 4, sample, folder))
