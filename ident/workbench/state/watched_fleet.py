"""The store of a fleet that the page shows: its alarms, its page, and the acknowledgement of alarms."""

from pathlib import Path

from ident.fleet import alarms, page
from ident.fleet.alarms import Alarm
from ident.fleet.store import Store
from ident.workbench.topics import Changes


class WatchedFleet:
    """One store of `ident fleet`, read anew each time: another run may have changed it."""

    def __init__(self, folder: Path, changes: Changes) -> None:
        """Open the store in `folder`.

        Raises:
            BadInput: it is none.
        """
        self._store, self._changes = Store(folder), changes
        self.name = folder.name
        alarms.load(self._store)

    def alarms(self) -> list[tuple[Alarm, str]]:
        """All alarms with what they say, open ones first."""
        everything = alarms.load(self._store).alarms
        ordered = sorted(everything, key=lambda alarm: (alarm.acknowledged, alarm.robot, alarm.since))
        return [(alarm, page.sentence(alarm)) for alarm in ordered]

    def page(self) -> str:
        """The page of the fleet, as `ident fleet report` writes it."""
        return page.render(self._store, alarms.load(self._store))

    def acknowledge(self, identity: str, note: str) -> None:
        """Acknowledge one alarm.

        Raises:
            BadInput: there is no such alarm, or `ident fleet` uses the store.
        """
        with self._store.locked():
            alarms.acknowledge(self._store, [identity], note)
        self._changes.mark("fleet")
