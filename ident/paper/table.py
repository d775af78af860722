"""Print the comparison of the methods beside the paper's values, with its interpretation."""

from collections.abc import Iterator

from rich.console import Console

from ident.identification.goodness_of_fit import GoodnessOfFit
from ident.output.console.printing import print_plain, print_table
from ident.output.tables import ResultTable
from ident.paper.methods import BASELINES, FAIR_BASELINE, MANUFACTURER, PAPER, ROLES, MethodComparison

MODELS = (
    "rls, dls and svd identify the linear model (37)-(40): multipliers taken as constants, no friction. pso (the "
    "paper's), pso_classic (Appendix C), lad (exact minimum of the swarms' objective), ls and wls (plain and "
    "weighted least squares: the fair variant of the baselines) identify (26). The manufacturer's is Table 1 in (1)."
)


def show(comparison: MethodComparison, console: Console) -> None:
    """Print Table 2, the order of the methods, its reasons, and what is comparable with the paper."""
    for role in range(len(ROLES)):
        print_table(console, _table(comparison, role))
    for line in (
        MODELS,
        *_order_sentences(comparison),
        *_cause_sentences(comparison),
        _manufacturer(comparison),
        _comparability(comparison),
    ):
        print_plain(console, line)


def _table(comparison: MethodComparison, role: int) -> ResultTable:
    rows = [
        (method, *_values(result.goodness_of_fit[role].nrmse), *_values(PAPER.get(method, ())))
        for method, result in comparison.results.items()
    ]
    rows.append((MANUFACTURER, *_values(comparison.nominal[role].nrmse)))
    head = ("method", *(f"{source} {joint}" for source in ("joint", "paper") for joint in (1, 2, 3)))
    name = comparison.prepared[role].recording.path.name
    title = f"Table 2 on {ROLES[role]} data ({name}): fitness, Eq. (41)"
    return ResultTable(head, rows, title=title, sections=(len(PAPER) - 1, len(rows) - 2))


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
            yield _order(comparison, role)


def _order(comparison: MethodComparison, role: int) -> str:
    """The order of the paper's methods where PSO is above all others, by the mean of the joints."""
    printed = sorted(PAPER, key=lambda method: -sum(PAPER[method]))
    found = sorted(PAPER, key=lambda method: -_mean(comparison.results[method].goodness_of_fit[role]))
    if found == printed:
        return f"The paper's order holds on {ROLES[role]} data: {', '.join(found)}."
    return (
        f"PSO is first on {ROLES[role]} data on every joint, as in the paper. The others stand otherwise: "
        f"{', '.join(found[1:])} (mean of the joints) where the paper has {', '.join(printed[1:])}. They fit the "
        "same model and differ in damping, threshold and start only, which the paper does not print."
    )


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
        everywhere = not comparison.baselines_not_below(role, FAIR_BASELINE)
        yield (
            f"On {name} data the best baseline is {best:.4f} (mean of the joints), least squares with the swarm's "
            f"model {fair:.4f}, PSO {swarm:.4f}: "
            + (
                "the model makes the difference (friction, multipliers that vary), not the search."
                if everywhere and abs(swarm - fair) < abs(fair - best)
                else "neither the model nor the search makes a difference on every joint."
            )
        )
    excess = comparison.results["pso"].excess
    yield f"PSO ended at most {excess:.1e} (relative) above the certified minimum of (33), which lad computes too."


def _manufacturer(comparison: MethodComparison) -> str:
    """In how many places the model that is not fitted is above the baselines on data that no fit saw, and why."""
    nominal = comparison.nominal[1].nrmse
    pairs = [
        (own, value)
        for method in BASELINES
        for own, value in zip(nominal, comparison.results[method].goodness_of_fit[1].nrmse, strict=True)
    ]
    above = sum(own > value for own, value in pairs)
    why = (
        ": it has the robot's geometry, which carries over to another motion, whereas multipliers that are taken as "
        "constants fit the motion that they were found on"
    )
    return (
        f"The manufacturer's model, which is not fitted, is above RLS, DLS and SVD in {above} of {len(pairs)} places "
        f"on validation data{why if 2 * above > len(pairs) else ''}."
    )


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
