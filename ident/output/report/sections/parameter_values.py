"""Table of the parameters of a diagnosis."""

from collections.abc import Mapping

from ident.diagnosis.document.document import ParameterValue
from ident.output.figures.theme import interval, number
from ident.output.report.blocks import ReportTable


def table(values: Mapping[str, ParameterValue]) -> ReportTable:
    """Return a table of the parameters with intervals, units and meanings."""
    head = ("parameter", "value", "95 % interval", "unit", "meaning")
    return ReportTable(head, tuple(_row(name, value) for name, value in values.items()), words=(0, 3, 4))


def _row(name: str, value: ParameterValue) -> tuple[str, ...]:
    bounds = interval(*value.interval) if value.interval else "–"
    amount = "never" if value.infinite else number(value.value, 4)
    return (name, amount, bounds, value.unit, value.meaning)
