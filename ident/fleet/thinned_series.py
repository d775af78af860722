"""Quantities over time as the page of a fleet draws them: no more points for years than for months."""

from dataclasses import dataclass, field

POINTS = 32
"""Points of a trend from which on two neighbours become one."""

Point = tuple[float, float, float, int]
"""Day, value, half of its 95 % interval (0: none), and number of nights of which these are the means."""


@dataclass
class ThinnedSeries:
    """One quantity of one robot."""

    kind: str
    joint: int | None
    """From 1; None: of the whole robot."""
    unit: str
    points: dict[int, list[Point]] = field(default_factory=dict)
    """In the order of time, by the number of the motion."""

    def add(self, motion: int, day: float, value: float, half: float) -> None:
        """Take the next night."""
        points = self.points.setdefault(motion, [])
        points.append((day, value, half, 1))
        if len(points) > POINTS:
            single = points[len(points) // 2 * 2 :]
            self.points[motion] = [*map(_mean, points[::2], points[1::2]), *single]


def _mean(one: Point, other: Point) -> Point:
    count = one[3] + other[3]
    day, value, half = ((a * one[3] + b * other[3]) / count for a, b in zip(one[:3], other[:3], strict=True))
    return day, value, half, count
