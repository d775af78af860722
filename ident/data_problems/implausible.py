"""Recordings that cannot be what they are said to be: nothing is fitted to them, and no effect is named."""

from collections.abc import Sequence
from typing import Literal

from recordings.config import JsonDocument
from recordings.data_problems import DataProblem
from recordings.errors import BadInput


class ProblemsDocument(JsonDocument):
    """What cannot be right about recordings."""

    data_problems: tuple[DataProblem, ...]
    recordings: tuple[str, ...]


class ImplausibleDocument(ProblemsDocument):
    """The result of every command on recordings that cannot be used."""

    verdict: Literal["implausible-data"] = "implausible-data"
    sentence: str
    findings: tuple[()] = ()
    likely: tuple[()] = ()


class ImplausibleData(BadInput):
    """Some of the `problems` of recordings block."""

    def __init__(self, recordings: Sequence[str], problems: Sequence[DataProblem]) -> None:
        self.recordings, self.problems = tuple(recordings), tuple(problems)
        reasons = [f"{each.kind}: {each.why} {each.remedy}" for each in problems if each.blocks]
        super().__init__("\n".join([f"{', '.join(recordings)}: data that can be right expected, found", *reasons]))

    @property
    def document(self) -> ImplausibleDocument:
        """What a command prints in place of its result."""
        return ImplausibleDocument(
            schema=2,
            sentence=" ".join(each.why for each in self.problems if each.blocks),
            data_problems=self.problems,
            recordings=self.recordings,
        )
