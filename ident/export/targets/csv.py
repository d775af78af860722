"""A feed-forward table over the motion: what `ident torque` writes, with all effects."""

from ident.export import tables, torque_table
from ident.export.losses import Carried, sorted_by
from ident.export.targets import ExportRequest
from ident.export.targets import beside as carried_file
from recordings.files import replacement

__all__ = ["carried_file", "write"]


def write(request: ExportRequest) -> Carried:
    """See `Target`."""
    rows = torque_table.tables(request.model, request.path, torque_table.TorqueSummary())
    with replacement(request.out) as partial:
        tables.load("csv")(rows, partial)
    return sorted_by(request.model, {})
