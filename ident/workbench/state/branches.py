"""Branches: alternative lists of steps with undo and redo. Nothing is computed here."""

from dataclasses import dataclass, replace
from string import ascii_uppercase

from ident.workbench.worker.views import StepsView
from recordings.errors import BadInput

MAX_BRANCHES = 6
"""Largest number of branches that remain distinguishable in one plot."""


@dataclass(frozen=True, eq=False)
class Branch:
    """One list of steps with its history."""

    name: str
    history: tuple[StepsView, ...]
    """Lists of steps in the order in which they were made."""
    undone: int = 0
    """How many of the last ones were undone."""

    @property
    def step_list(self) -> StepsView:
        """Return the current list of steps."""
        return self.kept[-1]

    @property
    def kept(self) -> tuple[StepsView, ...]:
        """Return the lists of steps up to the current one."""
        return self.history[: len(self.history) - self.undone]

    @property
    def can_undo(self) -> bool:
        """Whether the current list of steps is not the first one."""
        return len(self.kept) > 1

    @property
    def title(self) -> str:
        """Return the name and the effects that were added to the mandatory ones."""
        added = " + ".join(name for name, _ in self.step_list.added)
        return f"{self.name}: {added or self.step_list.steps[-1].label}"


@dataclass(frozen=True, eq=False)
class Branches:
    """All branches and the index of the current one. Immutable: every change returns a new object."""

    all: tuple[Branch, ...]
    index: int = 0

    def __post_init__(self) -> None:
        """Refuse what a damaged file may say; nothing here makes it."""
        undone = (0 <= branch.undone < len(branch.history) and branch.step_list.steps for branch in self.all)
        if not (0 <= self.index < len(self.all) and all(undone)):
            raise ValueError("a current branch with a current model expected")

    @classmethod
    def start(cls, step_list: StepsView) -> "Branches":
        """Return a single branch with its first list of steps."""
        return cls((Branch(ascii_uppercase[0], (step_list,)),))

    @property
    def current(self) -> Branch:
        """Return the branch that is being worked on."""
        return self.all[self.index]

    @property
    def has_changes(self) -> bool:
        """Whether there is more than the first model."""
        return len(self.all) > 1 or len(self.current.history) > 1

    def extended(self, step_list: StepsView) -> "Branches":
        """Append `step_list` to the current branch and discard what was undone."""
        return self._with_current(Branch(self.current.name, (*self.current.kept, step_list)))

    def undone(self) -> "Branches":
        """Go one list of steps back in the current branch.

        Raises:
            BadInput: the branch is at its first list of steps.
        """
        if not self.current.can_undo:
            raise BadInput("a change to undo expected, none found; this is the first model of the branch")
        return self._with_current(replace(self.current, undone=self.current.undone + 1))

    def redone(self) -> "Branches":
        """Restore the list of steps that was undone last.

        Raises:
            BadInput: nothing was undone.
        """
        if not self.current.undone:
            raise BadInput("an undone change expected, none found; there is nothing to redo")
        return self._with_current(replace(self.current, undone=self.current.undone - 1))

    def forked(self) -> "Branches":
        """Copy the current branch; the copy becomes the current one.

        Raises:
            BadInput: `MAX_BRANCHES` is reached.
        """
        if len(self.all) >= MAX_BRANCHES:
            raise BadInput(f"up to {MAX_BRANCHES} branches expected, one more requested; drop one first")
        used_names = {branch.name for branch in self.all}
        free_name = next(letter for letter in ascii_uppercase if letter not in used_names)
        return Branches((*self.all, Branch(free_name, self.current.kept)), len(self.all))

    def switched(self, index: int) -> "Branches":
        """Make branch `index` (from 0) the current one.

        Raises:
            BadInput: there is no such branch.
        """
        self._check_index(index)
        return replace(self, index=index)

    def dropped(self, index: int) -> "Branches":
        """Remove branch `index` (from 0).

        Raises:
            BadInput: it is the current branch, or there is no such branch.
        """
        self._check_index(index)
        if index == self.index:
            raise BadInput("a branch other than the current one expected; switch to another branch first")
        remaining = (*self.all[:index], *self.all[index + 1 :])
        return Branches(remaining, self.index - (index < self.index))

    def _check_index(self, index: int) -> None:
        if not 0 <= index < len(self.all):
            raise BadInput(f"one of {len(self.all)} branches expected, number {index + 1} found; reload the page")

    def _with_current(self, branch: Branch) -> "Branches":
        return replace(self, all=(*self.all[: self.index], branch, *self.all[self.index + 1 :]))
