"""Print the comparison of the methods beside the paper's values, with its interpretation."""

from collections.abc import Iterator

from rich.console import Console
from rich.table import Table

from ident.identification.goodness_of_fit import GoodnessOfFit
from ident.paper.methods import BASELINES, FAIR_BASELINE, MANUFACTURER, PAPER, ROLES, MethodComparison

MODELS = (
    "rls, dls and svd identify the linear model (37)-(40): multipliers taken as constants, no friction. pso (the "
    "paper's), pso_classic (Appendix C), lad (exact minimum of the swarms' objective), ls and wls (plain and "
    "weighted least squares: the fair variant of the baselines) identify (26). The manufacturer's is Table 1 in (1)."
)


def show(comparison: MethodComparison, console: Console) -> None:
    """Print Table 2, the order of the methods, its reasons, and what is comparable with the paper."""
    for role in range(len(ROLES)):
        console.print(_table(comparison, role))
    for line in (MODELS, *_order_sentences(comparison), *_cause_sentences(comparison), _comparability(comparison)):
        console.print(line, highlight=False)


def _table(comparison: MethodComparison, role: int) -> Table:
    name = comparison.prepared[role].recording.path.name
    table = Table(title=f"Table 2 on {ROLES[role]} data ({name}): fitness, Eq. (41)", title_justify="left")
    table.add_column("method")
    for source in ("joint", "paper"):
        for joint in (1, 2, 3):
            table.add_column(f"{source} {joint}", justify="right")
    for method, result in comparison.results.items():
        printed = _values(PAPER[method]) if method in PAPER else []
        table.add_row(
            method, *_values(result.goodness_of_fit[role].nrmse), *printed, end_section=method == list(PAPER)[-1]
        )
    table.add_section()
    table.add_row(MANUFACTURER, *_values(comparison.nominal[role].nrmse))
    return table


def _values(values: tuple[float, ...]) -> list[str]:
    return [f"{value:.4f}" for value in values]


def _order_sentences(comparison: MethodComparison) -> Iterator[str]:
    for role, name in enumerate(ROLES):
        not_below = comparison.baselines_not_below(role)
        if not_below:
            places = ", ".join(f"{method} on joint {joint}" for method, joint in not_below)
            yield f"The paper's order does not hold on {name} data: PSO is not above {places}."
            yield _reason(comparison, role)
        else:
            yield f"The paper's order holds on {name} data: PSO is above RLS, DLS and SVD on every joint."


def _reason(comparison: MethodComparison, role: int) -> str:
    """Explain why a baseline is not below the swarm on the data of `role`."""
    if not comparison.baselines_not_below(role, FAIR_BASELINE):
        return (
            "Least squares with the same model is above them all: Eq. (41) measures squared errors, whereas the "
            "swarm minimises absolute ones."
        )
    return (
        "Nor is least squares with the same model: these data do not show the advantage of the model, for example "
        "because differences of raw angles amplify the encoder's noise (try --preprocess parallel)."
    )


def _cause_sentences(comparison: MethodComparison) -> Iterator[str]:
    """Explain whether the model or the search makes the difference."""
    for role, name in enumerate(ROLES):
        swarm, fair = (_mean(comparison.results[method].goodness_of_fit[role]) for method in ("pso", FAIR_BASELINE))
        best = max(_mean(comparison.results[method].goodness_of_fit[role]) for method in BASELINES)
        by_model = abs(swarm - fair) < abs(fair - best)
        yield (
            f"On {name} data the best baseline is {best:.4f} (mean of the joints), least squares with the swarm's "
            f"model {fair:.4f}, PSO {swarm:.4f}: "
            + (
                "the model makes the difference (friction, multipliers that vary), not the search."
                if by_model
                else "least absolute instead of least squared residuals make a difference, not the model alone."
            )
        )
    excess = comparison.results["pso"].excess
    yield f"PSO ended at most {excess:.1e} (relative) above the certified minimum of (33), which lad computes too."


def _mean(fitness: GoodnessOfFit) -> float:
    return sum(fitness.nrmse) / len(fitness.nrmse)


def _comparability(comparison: MethodComparison) -> str:
    simulated = any(prepared.recording.run.simulated for prepared in comparison.prepared)
    robot = "a SIMULATED robot" if simulated else "another robot"
    return (
        "Comparable with the paper: the order of the methods. Not comparable: the values. These recordings are of "
        f"{robot} with its own friction, noise and voltages, on other paths (Figure 5 prints no "
        "coordinates), and Eq. (41) divides by the range of each model's own torque, which depends on the path. The "
        "paper prints neither the damping of DLS, nor the threshold of SVD, nor the start of RLS; nor does it say on "
        "which of its two recordings Table 2 was computed, so both are shown."
    )
