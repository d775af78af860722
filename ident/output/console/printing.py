"""Print texts, tables and data problems as they are: what looks like markup comes from a user's file and is none."""

from collections.abc import Sequence

from rich.box import HEAVY_HEAD, Box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ident.data_problems.implausible import ImplausibleDocument
from ident.output.tables import ResultTable
from recordings.data_problems import DataProblem


def print_plain(console: Console, text: str, style: str | None = None) -> None:
    """Print `text` without markup."""
    console.print(text, style=style, markup=False, highlight=False)


def print_command(console: Console, command: str) -> None:
    """Print a command, never wrapped, so that it can be copied."""
    console.print(command, markup=False, highlight=False, soft_wrap=True)


def print_simulated(console: Console, simulated: bool) -> None:
    """Say that no real robot moved."""
    if simulated:
        print_plain(console, "SIMULATED data.", "bold yellow")


def print_table(console: Console, table: ResultTable, box: Box | None = HEAVY_HEAD) -> None:
    """Print a table below its title."""
    shown = Table(title=Text(table.title, "table.title"), title_justify="left", box=box)
    shown.caption = Text(table.caption, "table.caption") if table.caption else None
    for column, heading in enumerate(table.head):
        shown.add_column(Text(heading), justify="left" if column in table.words else "right")
    for number, row in enumerate(table.rows):
        shown.add_row(*map(Text, row), style=table.styles.get(number), end_section=number in table.sections)
    console.print(shown)


def show_problems(problems: Sequence[DataProblem], console: Console) -> None:
    """Print every problem with its remedy."""
    for problem in problems:
        print_plain(console, f"Data problem ({problem.kind}): {problem.why}")
        print_command(console, f"  {problem.remedy}")


def show_implausible(document: ImplausibleDocument, console: Console) -> None:
    """Print the problems, and that nothing was done."""
    show_problems(document.data_problems, console)
    blocking = dict.fromkeys(problem.kind for problem in document.data_problems if problem.blocks)
    console.print(f"\n{document.verdict}", style="bold red", end=": ")
    accepted = " ".join(f"--accept {kind}" for kind in blocking)
    print_plain(console, f"nothing is fitted to such data, and no effect is named ({accepted} does so all the same).")
