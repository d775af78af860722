"""Draw Figures 3 and 6 to 10 of the paper with the given recordings."""

from pathlib import Path

from ident.output.pictures import torque
from ident.paper.methods import MANUFACTURER, MethodComparison

_IDENTIFICATION, _VALIDATION = 0, 1


def draw(comparison: MethodComparison, folder: Path) -> None:
    """Draw all figures into `folder`, named by their numbers in the paper."""
    identification, validation = comparison.prepared
    curves = {name: result.torque[_IDENTIFICATION] for name, result in comparison.results.items()}
    assert identification.nominal is not None
    manufacturer, pso = {MANUFACTURER: identification.nominal}, {"pso": curves["pso"]}
    title = "Figure 3: (a) manufacturer's model, (b) model identified by PSO"
    torque(folder / "figure_3.png", title, identification, [manufacturer, pso])
    torque(folder / "figure_6.png", "Figure 6: measured, and identified by PSO", identification, [pso])
    for number, method in ((7, "rls"), (8, "dls"), (9, "svd")):
        title = f"Figure {number}: measured, identified by {method.upper()}, identified by PSO"
        torque(folder / f"figure_{number}.png", title, identification, [{**pso, method: curves[method]}])
    validated = {name: comparison.results[name].torque[_VALIDATION] for name in ("pso", "rls", "dls", "svd")}
    torque(folder / "figure_10.png", "Figure 10: validation on another motion", validation, [validated])
