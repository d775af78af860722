"""What tests make up for the recordings that they write."""

from typing import Any

from recordings.recording import Run


def run_of(**changes: Any) -> Run:
    """A run of fig5a on the simulated rig, but for these changes."""
    given: dict[str, Any] = {
        "trajectory": "fig5a",
        "trajectory_digest": "d1f0",
        "period": 0.0,
        "cycles": 2,
        "rate": 500.0,
        "software": "0.1.0",
        "simulated": True,
        "pace": "lockstep",
        "start": "2023-11-14T22:13:20+00:00",
    }
    return Run(**given | changes)
