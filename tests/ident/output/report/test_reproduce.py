"""The commands of a report can be run again."""

from pathlib import Path

from ident.output.report.contents import ReportRequest
from ident.output.report.sections.reproduce import file_names


def request(*recordings: str) -> ReportRequest:
    return ReportRequest((Path("a/fig5a.model.json"),), tuple(map(Path, recordings)), (), (), diagnose=True)


def test_files_with_equal_names_are_listed_with_their_folders() -> None:
    assert [*file_names(request("a/fig5a.mcap", "b/fig5b.mcap")).values()] == [
        "fig5a.model.json",
        "fig5a.mcap",
        "fig5b.mcap",
    ]
    ambiguous = file_names(request("a/fig5a.mcap", "b/fig5a.mcap", "b/c/fig5b.mcap"))
    assert [*ambiguous.values()] == ["a/fig5a.model.json", "a/fig5a.mcap", "b/fig5a.mcap", "b/c/fig5b.mcap"]
