"""How far a fit can be trusted, on the screen: a few lines, or tables with all details."""

from collections.abc import Iterator

import numpy as np
from rich.console import Console
from rich.table import Table

from ident.identification.model import FittedParameter, Model
from ident.uncertainty.assessment import JointFloor, Trust

NOTABLE = 0.7
"""Correlation from which two parameters are named together."""
MANY = 5
"""So many correlations are named without being asked for details."""


def show(model: Model, console: Console, details: bool) -> None:
    """Print what is known about the errors of `model`."""
    if model.trust is None:
        return
    console.print("How far to trust it:")
    for line in summary_lines(model, model.trust):
        console.print(f"  {line}", highlight=False)
    if details:
        console.print(_parameters(model, model.trust))
        console.print(_correlations(model, model.trust))
        if model.trust.floor:
            console.print(_floors(model, model.trust.floor))


def half_width(parameter: FittedParameter) -> str:
    """Half the width of the 95 % interval, to two digits."""
    return "" if parameter.ci95 is None else _digits((parameter.ci95[1] - parameter.ci95[0]) / 2)


def length_sensitivity(model: Model) -> str:
    """What 10 mm more of L2 do, as the end of a sentence."""
    moved = {p.name: p.per_length_step / abs(p.value) for p in model.parameters if p.per_length_step and p.value}
    if not moved:
        return ""
    most = max(moved, key=lambda name: abs(moved[name]))
    named = dict.fromkeys(["m_p", most]) if "m_p" in moved else {most: None}
    return "; 10 mm more move " + " and ".join(f"{name} by {100 * moved[name]:+.2g} %" for name in named)


def summary_lines(model: Model, trust: Trust) -> Iterator[str]:
    """The short form."""
    yield _about_intervals(trust)
    yield _about_noise(model, trust)
    yield from _about_trends(trust)
    yield _about_identifiability(model, trust)
    yield from (f"{one.sentence}." for one in trust.inseparable)
    yield from _about_correlation(model, trust)
    yield from (f"Not physical: {doubt.sentence}." for doubt in trust.doubts)
    if trust.coupling:
        doubt = "" if trust.coupling.positive else "; D(θ) is not positive definite: NOT PHYSICAL"
        share = f"{100 * trust.coupling.share:.0f} % of the whole"
        yield f"Inertia coupling between the joints: off-diagonal part of D(θ), Eq. (27), {share}{doubt}."
    yield from _about_cutoffs(model, trust)


def _about_intervals(trust: Trust) -> str:
    sources = {
        "stationary": "noise taken as stationary in volts",
        "hac": "Newey-West",
        "cycles": "differences between repetitions",
    }
    if trust.gain_uncertainty:
        gain = f"the gain's {100 * trust.gain_uncertainty:.2g} % included"
    else:
        gain = "absolute" if trust.absolute else "up to the common factor of the gain: only ratios are claimed"
    return (
        f"± is the 95 % interval of a fit of least {trust.loss} ({sources[trust.source]}; residuals may be "
        f"autocorrelated), given model and geometry; {gain}."
    )


def _about_noise(model: Model, trust: Trust) -> str:
    unit, drive = model.effort_units[0], trust.noise[0].unit
    signal = f"{', '.join(_digits(joint.volts) for joint in trust.noise)} {drive}"
    if trust.floor is None:
        return f"Noise floor: unknown, as the motion is not repeated; noise seen {trust.noise[0].source}: {signal}."
    floors = ", ".join(_digits(joint.noise_rms) for joint in trust.floor)
    shares = ", ".join(f"{100 * joint.above_noise:.0f}" for joint in trust.floor)
    return (
        f"Noise floor from {trust.floor[0].cycles} repetitions: {floors} {unit} RMS ({signal}); {shares} % of the "
        "residual's mean square is above it."
    )


def _about_trends(trust: Trust) -> Iterator[str]:
    for number, joint in enumerate(trust.floor or (), start=1):
        if joint.trend:
            yield (
                f"Joint {number}: the residual changes from repetition to repetition ({joint.trend.pattern}, "
                f"p = {joint.trend.p_value:.1g}): look for drift or a change of load."
            )


def _about_identifiability(model: Model, trust: Trust) -> str:
    known = [parameter.name for parameter in model.parameters if parameter.status == "identifiable"]
    rest = {status: [p.name for p in model.parameters if p.status == status] for status in ("weak", "not")}
    words = {"weak": "only weakly identifiable", "not": "NOT identifiable"}
    said = [f"{words[status]}: {', '.join(names)}" for status, names in rest.items() if names]
    every = "all parameters are" if len(known) == len(model.parameters) else f"{len(known)} parameters are"
    return f"Condition number {trust.condition_number:.3g}; {'; '.join([f'{every} identifiable', *said])}."


def _about_correlation(model: Model, trust: Trust) -> Iterator[str]:
    pairs = sorted(
        (
            (rho, model.parameters[i].name, model.parameters[j].name)
            for i, row in enumerate(trust.correlation)
            for j, rho in enumerate(row[:i])
            if rho is not None and abs(rho) >= NOTABLE
        ),
        key=lambda pair: -abs(pair[0]),
    )
    if pairs:
        named = ", ".join(f"{one} and {other} {rho:+.2f}" for rho, one, other in pairs[:MANY])
        more = f", and {len(pairs) - MANY} more" if len(pairs) > MANY else ""
        yield f"Strongly correlated errors: {named}{more}."
    yield from _about_offsets(model, trust)


def _about_offsets(model: Model, trust: Trust) -> Iterator[str]:
    """However strong: where a direction of motion is rare, an offset and Coulomb friction are nearly the same."""
    index = {parameter.name: i for i, parameter in enumerate(model.parameters)}
    for name, i in index.items():
        other = index.get(f"torque_offset.a{name.removeprefix('c_c')}") if name.startswith("c_c") else None
        rho = None if other is None else trust.correlation[max(i, other)][min(i, other)]
        if rho is not None and other is not None:
            yield f"Coulomb friction {name} and {model.parameters[other].name}: errors correlate by {rho:+.2f}."


def _about_cutoffs(model: Model, trust: Trust) -> Iterator[str]:
    for i, hz in enumerate(trust.cutoffs):
        moved = {p.name: p.per_cutoff[i] / p.std for p in model.parameters if p.std}
        if moved:
            most = max(moved, key=lambda name: abs(moved[name]))
            yield f"A cut-off of {hz:.3g} Hz moves {most} most, by {moved[most]:+.1f} standard errors."


def _parameters(model: Model, trust: Trust) -> Table:
    table = Table(title="Parameters in detail", title_justify="left")
    moves = ["L2", *(f"{hz:.3g} Hz" for hz in trust.cutoffs)]
    for heading in ("", "from", "to", "error", "freedom", "known", *moves):
        table.add_column(heading, justify="left" if heading in ("", "known") else "right")
    known = {"identifiable": "yes", "weak": "weakly", "not": "no", None: ""}
    for p in model.parameters:
        ends = ("", "") if p.ci95 is None else (f"{p.ci95[0]:.4g}", f"{p.ci95[1]:.4g}")
        changes = [
            None if p.std is None or move is None else move / p.std for move in (p.per_length_step, *p.per_cutoff)
        ]
        cells = [_optional(p.std, ".2g"), _optional(p.degrees_of_freedom, ".0f"), known[p.status]]
        table.add_row(p.name, *ends, *cells, *(_optional(change, "+.1f") for change in changes))
    table.caption = (
        "95 % interval; standard error and its degrees of freedom; whether it is identifiable; by how many standard "
        "errors it moves where L2 is 10 mm longer, and with another cut-off."
    )
    return table


def _correlations(model: Model, trust: Trust) -> Table:
    table = Table(title="Correlation of the errors, in percent", title_justify="left")
    table.add_column("")
    for parameter in model.parameters:
        table.add_column(parameter.name, justify="right")
    for parameter, row in zip(model.parameters, trust.correlation, strict=True):
        table.add_row(parameter.name, *("" if rho is None else f"{100 * rho:.0f}" for rho in row))
    return table


def _floors(model: Model, floor: tuple[JointFloor, ...]) -> Table:
    table = Table(title=f"Residual, RMS [{model.effort_units[0]}]", title_justify="left")
    for heading in ("joint", "repetitions", "all", "noise", "repeats with the motion", "by chance"):
        table.add_column(heading, justify="right")
    for number, joint in enumerate(floor, start=1):
        rms = [f"{np.sqrt(max(square, 0.0)):.3g}" for square in (joint.total, joint.noise, joint.repeating)]
        table.add_row(str(number), str(joint.cycles), *rms, f"p = {joint.repeating_p:.1g}")
    return table


def _optional(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form)


def _digits(value: float) -> str:
    """Two significant digits, without an exponent where it can be helped."""
    return f"{value:.2g}" if value < 100 else f"{value:.0f}"
