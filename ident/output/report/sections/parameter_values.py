"""Parameters of a diagnosis as a table."""

from collections.abc import Mapping

from ident.diagnosis.document import ParameterValue
from ident.output.figures.theme import interval, number
from ident.output.report.blocks import ReportTable


def table(values: Mapping[str, ParameterValue]) -> ReportTable:
    """By name, with intervals and what they mean."""
    head = ("parameter", "value", "95 % interval", "unit", "meaning")
    return ReportTable(head, tuple(_row(name, value) for name, value in values.items()), words=(0, 3, 4))


def _row(name: str, value: ParameterValue) -> tuple[str, ...]:
    known = interval(*value.ci95) if value.ci95 else "–"
    amount = "never" if value.infinite else number(value.value, 4)
    return (name, amount, known, value.unit, value.meaning)
