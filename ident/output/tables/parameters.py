"""Tables of the parameters of models, and of the agreement of models with recordings."""

from collections.abc import Mapping

from ident.diagnosis.document.document import ParameterValue
from ident.dynamics.effects.base import is_infinite
from ident.identification.model_file import FittedParameter, ModelFile
from ident.output.assessment import half_width, scale_line, two_digits
from ident.output.digits import interval, number
from ident.output.tables import ResultTable
from ident.uncertainty.assessment import Assessment

_KNOWN = {"identifiable": "yes", "weak": "weakly", "not": "no", None: ""}


def fitted(model: ModelFile) -> ResultTable:
    """Return the values with half their intervals, of the paper's model also as in (36)."""
    of_paper = model.mechanism == "delta" and model.form is None
    equation = " of Eq. (26)" if of_paper and not model.effects else " of Eq. (38)" if model.form else ""
    head = [
        "",
        "value",
        *(["± 95 %"] if model.assessment else []),
        "unit",
        *(["as in (36)"] if of_paper else ["meaning"]),
    ]
    rows = [
        (
            parameter.name,
            _value(parameter.value, parameter.unit),
            *([_half(parameter)] if model.assessment else []),
            parameter.unit,
            _value(parameter.paper_value, parameter.unit) if of_paper else parameter.meaning,
            "yes" if parameter.at_bound else "",
        )
        for parameter in model.all_parameters
    ]
    sign = "; (36) has the opposite sign." if of_paper else "."
    return ResultTable(
        (*head, "at bound"),
        rows,
        "" if model.form else f"Friction is positive where it opposes motion{sign}",
        words=(0, head.index("unit"), *(() if of_paper else (len(head) - 1,)), len(head)),
        title=f"Parameters{equation}{', relative' if model.relative else ''}",
    )


def side_by_side(models: Mapping[str, ModelFile]) -> ResultTable:
    """Return value, half interval and identifiability of each parameter in each model."""
    by_name = [{entry.name: entry for entry in model.all_parameters} for model in models.values()]
    rows = []
    for parameter, unit in {entry.name: entry.unit for entries in by_name for entry in entries.values()}.items():
        cells = [parameter]
        for entries in by_name:
            entry = entries.get(parameter)
            bound = " (at bound)" if entry and entry.at_bound else ""
            known = _KNOWN[None if entry.at_bound else entry.status] if entry else ""
            cells += [f"{number(entry.value, 4)}{bound}", _half(entry), known] if entry else [""] * 3
        rows.append((*cells, unit))
    scales = {
        scale_line(model.assessment.scale_uncertainty, model.relative)
        for model in models.values()
        if model.assessment
    }
    values = [f"{name}: value" if len(models) > 1 else "value" for name in models]
    head = ("parameter", *(cell for value in values for cell in (value, "± 95 %", "identifiable")), "unit")
    conditional = {
        warning.sentence
        for model in models.values()
        for warning in (model.assessment.warnings if model.assessment else ())
        if warning.kind == "conditional"
    }
    caption = " ".join(["Friction is positive where it opposes motion.", *sorted(scales), *conditional])
    return ResultTable(head, rows, caption, words=(0, len(head) - 1))


def with_meanings(values: Mapping[str, ParameterValue]) -> ResultTable:
    """Return the parameters of a diagnosis with intervals, units and meanings."""
    rows = [
        (
            name,
            "never" if value.infinite else number(value.value, 4),
            interval(*value.interval) if value.interval else "–",
            value.unit,
            value.meaning,
        )
        for name, value in values.items()
    ]
    return ResultTable(("parameter", "value", "95 % interval", "unit", "meaning"), rows, words=(0, 3, 4))


def details(model: ModelFile, assessment: Assessment) -> ResultTable:
    """Return interval and standard error of each parameter, and its changes with length L2 and cut-off."""
    with_length = any(parameter.per_length_step is not None for parameter in model.parameters)
    rows = []
    for p in model.all_parameters:
        limits = p.shape_ci95 or p.ci95
        changes = [*([p.per_length_step] if with_length else []), *p.per_cutoff]
        rows.append(
            (
                p.name,
                *(("", "") if limits is None else (f"{limits[0]:.4g}", f"{limits[1]:.4g}")),
                "" if p.std is None else f"{p.std:.2g}",
                "" if p.degrees_of_freedom is None else f"{p.degrees_of_freedom:.0f}",
                "at bound" if p.at_bound else _KNOWN[p.status],
                *("" if p.std is None or move is None else f"{move / p.std:+.1f}" for move in changes),
            )
        )
    changed = ["with L2 10 mm longer"] if with_length else []
    changed += ["with other cut-offs"] if assessment.cutoffs else []
    moves = [*(["L2"] if with_length else []), *(f"{hz:.3g} Hz" for hz in assessment.cutoffs)]
    return ResultTable(
        ("", "from", "to", "std. error", "dof", "known", *moves),
        rows,
        "95 % interval; standard error and its degrees of freedom (dof); whether the parameter is identifiable"
        f"{'; its change, in standard errors, ' if changed else ''}{' and '.join(changed)}.",
        words=(0, 5),
        title="Parameters in detail",
    )


def correlations(model: ModelFile, assessment: Assessment) -> ResultTable:
    """Return the correlation of the errors of all pairs of parameters."""
    names = [each.name for each in (*model.parameters, *model.searched)][: len(assessment.correlation)]
    rows = [
        (name, *("" if rho is None else f"{100 * rho:.0f}" for rho in row))
        for name, row in zip(names, assessment.correlation, strict=True)
    ]
    return ResultTable(("", *names), rows, title="Correlation of the errors, in percent")


def agreement(model: ModelFile) -> ResultTable:
    """Return how well each joint's torque agrees, of the fitted and, where it is known, of the nominal model."""
    rows, ends = [], []
    for name, found in (("training", model.train), ("validation", model.validate_)):
        fits = [fit for fit in (found.fitted, found.nominal) if fit] if found else []
        for joint in range(len(model.joints) if fits else 0):
            measures = [(f"{fit.nrmse[joint]:.4f}", f"{fit.rms[joint]:.3f}", f"{fit.r2[joint]:.4f}") for fit in fits]
            cells = map(" | ".join, zip(*measures, strict=True))
            rows.append((name if joint == 0 else "", str(joint + 1), *cells))
        ends.append(len(rows) - 1)
    compared = "fitted model" if model.train.nominal is None else "fitted model | Table 1 in Eq. (1)"
    units = ", ".join(dict.fromkeys(model.effort_units))
    head = ("data", "joint", "Eq. (41)", f"RMS [{units}]", "R²")
    title = f"Agreement with the measured torque: {compared}"
    caption = "" if model.form else "The fitted model's RMS is of the rows that are scored, all else of all rows."
    return ResultTable(head, rows, caption, words=(0, 1), title=title, sections=ends)


def _half(parameter: FittedParameter) -> str:
    half = half_width(parameter)
    return "" if half is None else two_digits(half)


def _value(value: float, unit: str) -> str:
    if is_infinite(value, unit):
        return "never"
    return f"{value:.4f}" if abs(value) >= 0.1 else f"{value:.4g}"
