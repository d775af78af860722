"""What was tried: ladders side by side, each with the way back and forth. Nothing is computed here."""

from dataclasses import dataclass, replace
from string import ascii_uppercase

from ident.workbench.views import LadderView
from recordings.errors import BadInput

_MOST_UNDONE = 50
MOST = 6
"""Branches that can still be told apart side by side."""


@dataclass(frozen=True, eq=False)
class Branch:
    """One way of explaining the recordings."""

    name: str
    past: tuple[LadderView, ...]
    """The last is the present one."""
    future: tuple[LadderView, ...] = ()
    """What was undone, the latest last."""

    @property
    def ladder(self) -> LadderView:
        """The present one."""
        return self.past[-1]

    @property
    def title(self) -> str:
        """Its name, and what it added to what is true of any such machine."""
        added = [name for name, _ in self.ladder.rungs[-1].terms if name not in self.ladder.always]
        return f"{self.name}: {' + '.join(added) or self.ladder.rungs[-1].label}"


@dataclass(frozen=True, eq=False)
class Branches:
    """All of them, and which one is being worked on. Every change gives new ones."""

    all: tuple[Branch, ...]
    place: int = 0

    @classmethod
    def begun(cls, ladder: LadderView) -> "Branches":
        """One branch with its first ladder."""
        return cls((Branch(ascii_uppercase[0], (ladder,)),))

    @property
    def present(self) -> Branch:
        """The one that is being worked on."""
        return self.all[self.place]

    def grown(self, ladder: LadderView) -> "Branches":
        """The present branch is now at `ladder`; what was undone before is given up."""
        past = (*self.present.past, ladder)[-_MOST_UNDONE:]
        return self._with(replace(self.present, past=past, future=()))

    def undone(self) -> "Branches":
        """One step back.

        Raises:
            BadInput: there is none.
        """
        *past, last = self.present.past
        if not past:
            raise BadInput("a change to undo expected, none found; this is where the ladder began")
        return self._with(replace(self.present, past=tuple(past), future=(*self.present.future, last)))

    def redone(self) -> "Branches":
        """What was undone last, again.

        Raises:
            BadInput: nothing was.
        """
        if not self.present.future:
            raise BadInput("a change that was undone expected, none found; there is nothing to redo")
        *future, again = self.present.future
        return self._with(replace(self.present, past=(*self.present.past, again), future=tuple(future)))

    def forked(self) -> "Branches":
        """The present branch stays as it is, and a copy of it, which is worked on from now on, stands beside it.

        Raises:
            BadInput: there are too many.
        """
        if len(self.all) >= MOST:
            raise BadInput(f"up to {MOST} branches expected, one more asked for; drop one first")
        taken = {branch.name for branch in self.all}
        free = next(letter for letter in ascii_uppercase if letter not in taken)
        return Branches((*self.all, replace(self.present, name=free, future=())), len(self.all))

    def switched(self, place: int) -> "Branches":
        """To the branch at `place` (from 0).

        Raises:
            BadInput: there is none.
        """
        self._refuse(place)
        return replace(self, place=place)

    def dropped(self, place: int) -> "Branches":
        """Without the branch at `place` (from 0), which is not the present one.

        Raises:
            BadInput: it is, or there is none.
        """
        self._refuse(place)
        if place == self.place:
            raise BadInput("another branch than the present one expected; switch to another one first")
        left = (*self.all[:place], *self.all[place + 1 :])
        return Branches(left, self.place - (place < self.place))

    def _refuse(self, place: int) -> None:
        if not 0 <= place < len(self.all):
            raise BadInput(f"one of {len(self.all)} branches expected, number {place + 1} found; look at them again")

    def _with(self, branch: Branch) -> "Branches":
        return replace(self, all=(*self.all[: self.place], branch, *self.all[self.place + 1 :]))
