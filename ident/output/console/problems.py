"""Print what cannot be right about data."""

from collections.abc import Sequence

from rich.console import Console

from ident.data_problems.implausible import ImplausibleDocument
from ident.output.console.printing import print_command, print_plain
from recordings.data_problems import DataProblem


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
