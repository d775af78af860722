"""History: every list of steps that was made, each from another one, and the one that is looked at.

Undo, redo, another branch, a reload and a new start of the server are one operation on it: `at`. Nothing is lost by
it, so that what is added after an undo is a branch. Nothing is computed here.
"""

from dataclasses import dataclass, replace

from ident.workbench.worker.views import StepsView
from recordings.errors import BadInput


@dataclass(frozen=True)
class Entry:
    """A list of steps."""

    made: StepsView
    before: int | None
    """Number of the entry that it was made from; None for the first one."""


@dataclass(frozen=True, eq=False)
class History:
    """All lists of steps. Immutable: every change returns a new object."""

    entries: tuple[Entry, ...]
    current: int
    """Number of the entry that is looked at."""
    end: int
    """Number of the entry where its branch ends: redo leads there."""

    def __post_init__(self) -> None:
        """Refuse what a damaged file may say; nothing here makes it."""
        earlier = all(entry.before is None or entry.before < number for number, entry in enumerate(self.entries))
        inside = earlier and 0 <= self.end < len(self.entries) and self.current in self.way(self.end)
        if not (inside and all(entry.made.steps for entry in self.entries)):
            raise ValueError("a current model among those of its branch expected")

    @classmethod
    def start(cls, made: StepsView) -> "History":
        """Return the history of a first list of steps."""
        return cls((Entry(made, None),), 0, 0)

    @property
    def made(self) -> StepsView:
        """The list of steps that is looked at."""
        return self.entries[self.current].made

    @property
    def undo(self) -> int | None:
        """Number of the entry before the current one."""
        return self.entries[self.current].before

    @property
    def redo(self) -> int | None:
        """Number of the entry after the current one, in its branch."""
        return next((number for number in self.way(self.end) if self.entries[number].before == self.current), None)

    @property
    def ends(self) -> tuple[int, ...]:
        """Numbers of the entries where the branches end."""
        continued = {entry.before for entry in self.entries}
        return tuple(number for number in range(len(self.entries)) if number not in continued)

    def way(self, end: int) -> list[int]:
        """Numbers of the entries from `end` back to the first one."""
        way: list[int] = []
        number: int | None = end
        while number is not None:
            way.append(number)
            number = self.entries[number].before
        return way

    def at(self, number: int | None) -> "History":
        """Look at an entry of any branch.

        Raises:
            BadInput: there is no such entry.
        """
        if number is None or not 0 <= number < len(self.entries):
            raise BadInput("another model of the history expected, none found; reload the page")
        end = self.end if number in self.way(self.end) else max(e for e in self.ends if number in self.way(e))
        return replace(self, current=number, end=end)

    def extended(self, made: StepsView) -> "History":
        """Append what was `made` from the current entry, in place of the same at an end, and look at it."""
        same = (made.steps[-1].terms, made.findings is None)
        for number in self.ends:
            entry = self.entries[number]
            if (entry.made.steps[-1].terms, entry.made.findings is None) == same and entry.before == self.current:
                entries = (*self.entries[:number], Entry(made, self.current), *self.entries[number + 1 :])
                return History(entries, number, number)
        last = len(self.entries)
        return History((*self.entries, Entry(made, self.current)), last, last)

    def without(self, end: int) -> "History":
        """Drop the branch with this `end`: the entries that belong to no other one.

        Raises:
            BadInput: it is the current branch, or no branch ends there.
        """
        others = [other for other in self.ends if other != end]
        if end == self.end or len(others) == len(self.ends):
            raise BadInput("a branch other than the current one expected; switch to another branch first")
        kept = sorted({number for other in others for number in self.way(other)})
        new = {old: number for number, old in enumerate(kept)}
        entries = [self.entries[old] for old in kept]
        renumbered = (Entry(entry.made, None if entry.before is None else new[entry.before]) for entry in entries)
        return History(tuple(renumbered), new[self.current], new[self.end])

    def title(self, end: int) -> str:
        """Return the effects that were added to the mandatory ones at the `end` of a branch, after its number."""
        made = self.entries[end].made
        added = " + ".join(name for name, _ in made.added)
        found = " (full diagnosis)" if made.findings else ""
        return f"{self.ends.index(end) + 1}: {added or made.steps[-1].label}{found}"
