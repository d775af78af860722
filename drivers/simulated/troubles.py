"""When something goes wrong with a simulated drive while it works."""

from collections.abc import Callable, Mapping, Sequence

from drivers.simulated.habits import Habits, Trouble

Due = tuple[float, Trouble]
"""When a trouble begins, in simulated time from power-on of the machine [s], and which."""


class Troubles:
    """Troubles of one drive: at fixed times, and by its habit some time after it got power."""

    def __init__(self, entries: Mapping[Trouble, Callable[[], None]], habits: Habits, due: Sequence[Due]) -> None:
        """`entries`: what each does."""
        self.entries = entries
        self._due = sorted(due)
        self._habit: Due | None = None if habits.trouble == "none" else (habits.trouble_after, habits.trouble)

    def begin(self, trouble: Trouble) -> None:
        """Begin with one now."""
        self.entries[trouble]()

    def pass_time(self, now: float, *, powered: bool) -> None:
        """Begin with those that are due at `now` [s]; `powered`: whether the drive has power."""
        if powered and self._habit is not None:
            self._due = sorted([*self._due, (now + self._habit[0], self._habit[1])])
            self._habit = None
        while self._due and self._due[0][0] <= now:
            self.begin(self._due.pop(0)[1])
