"""How many points of long traces the page holds."""

from ident.output.digits import percent
from ident.output.figures import theme

BUDGET = 3_000_000
"""Size of all traces over time in the page [bytes]; the whole page stays well below 10 MB."""
_POINT = 8 * 4 / 3
"""Size of a point [bytes]: two single precision numbers in base64."""
ZOOM = "Drag to zoom (all joints follow), double click for the whole recording."


def points(traces: int) -> int:
    """Return the number of points per trace at which so many `traces` keep to the budget."""
    return max(theme.MAX_POINTS, int(BUDGET / _POINT / traces))


def detail(rows: int, points: int) -> str:
    """Say which of the `rows` of a recording are drawn with so many `points`."""
    if rows <= points:
        return "Every sample is drawn."
    return (
        f"Every sample of the first repetition is drawn; of the rest the extremes, {percent(points / rows)}, so that "
        "no peak is lost."
    )
