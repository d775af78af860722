"""The commands of a report can be run again."""

from pathlib import Path

from ident.output.report.contents import Request
from ident.output.report.sections.reproduce import names


def request(*recordings: str) -> Request:
    return Request((Path("a/fig5a.model.json"),), tuple(map(Path, recordings)), (), (), diagnose=True)


def test_files_go_by_their_names_and_those_of_one_name_by_their_folders_too() -> None:
    assert [*names(request("a/fig5a.mcap", "b/fig5b.mcap")).values()] == [
        "fig5a.model.json",
        "fig5a.mcap",
        "fig5b.mcap",
    ]
    alike = names(request("a/fig5a.mcap", "b/fig5a.mcap", "b/c/fig5b.mcap"))
    assert [*alike.values()] == ["a/fig5a.model.json", "a/fig5a.mcap", "b/fig5a.mcap", "b/c/fig5b.mcap"]
