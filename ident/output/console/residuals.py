"""Print a residual analysis."""

from rich.console import Console

from ident.output.console.printing import print_plain, print_simulated, print_table, show_problems
from ident.output.tables import residuals
from ident.residuals.analysis import ResidualAnalysis


def show(analysis: ResidualAnalysis, console: Console) -> None:
    """Print a summary in sentences, the residual per joint and phase, its dependence, and the worst windows."""
    recordings = [prediction.prepared for prediction in analysis.predictions]
    print_simulated(console, any(prepared.recording.run.simulated for prepared in recordings))
    if analysis.model and analysis.model.relative:
        warning = "The torque gain is assumed: torques are RELATIVE, known up to one factor."
        print_plain(console, warning, "bold yellow")
    show_problems(analysis.data_problems, console)
    names = ", ".join(prepared.recording.path.name for prepared in recordings)
    for line in (f"Model against {names}, {recordings[0].bandwidth:g} Hz bandwidth", *analysis.sentences):
        print_plain(console, line)
    print_table(console, residuals.summary({"": analysis}))
    for table in (residuals.phases, residuals.dependence, residuals.windows):
        print_table(console, table(analysis))
