"""Print texts and tables as they are: what looks like markup comes from a user's file and is none."""

from rich.box import HEAVY_HEAD, Box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ident.output.tables import ResultTable


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
