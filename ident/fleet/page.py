"""The page of a fleet: at a glance, alarms with their evidence, every robot over time, and what cannot be used."""

from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path

import pyarrow.compute as pc

from ident.fleet import figures
from ident.fleet.alarms import Alarm, FleetFile
from ident.fleet.recording_rows import Row
from ident.fleet.series import Nights, Series, nights_and_series
from ident.fleet.store import Store
from ident.output.digits import number, percent
from ident.output.report.blocks import Card, Code, Fold, Notes, Plot, ReportBlock, ReportSection, Text
from ident.output.report.headline import Headline, Tile
from ident.output.report.page import assembled, write_page
from ident.output.tables import ResultTable

_MAX_SHOWN = 4
"""Quantities that are drawn below an alarm."""


def write(store: Store, content: FleetFile, out: Path) -> None:
    """Write the page of a `store` to `out`, or nothing.

    Raises:
        BadInput: the store is damaged, or the file cannot be written.
    """
    write_page(render(store, content), out)


def render(store: Store, content: FleetFile) -> str:
    """Return the whole page."""
    table = store.table()
    table = table.filter(pc.equal(table["settings"], content.settings))
    nights, series = nights_and_series(table)
    _, floors = nights_and_series(table, kinds=("floor",))
    failed = [row for row in table.to_pylist() if row["status"] == "failed"]
    alarms = sorted(content.alarms, key=lambda alarm: (alarm.acknowledged, alarm.robot, alarm.since))
    sections = [
        _glance(nights, failed, alarms),
        _alarms(alarms, series, store),
        _robots(nights, series, floors, alarms),
        *([_failed(failed)] if failed else []),
        _reproduce(content, store),
    ]
    data = content.model_dump(mode="json", by_alias=True)
    simulated = bool(pc.any(table["simulated"]).as_py())
    return assembled("Fleet", [str(store.folder)], _headline(nights, failed, alarms, simulated), sections, data)


def _headline(nights: Sequence[Nights], failed: Sequence[Row], alarms: Sequence[Alarm], simulated: bool) -> Headline:
    opened = [alarm for alarm in alarms if not alarm.acknowledged]
    count = sum(len(each.keys) for each in nights)
    verdict = "adequate"
    if opened:
        verdict = "missing-effect" if all(alarm.effect for alarm in opened) else "unknown-structure"
    plural = "s are" if len(opened) > 1 else " is"
    title = f"{len(opened)} alarm{plural} open" if opened else "No alarm is open"
    tiles = (
        Tile("robots", str(len(nights)), "with recordings that can be used"),
        Tile("recordings", str(count), f"and {len(failed)} that cannot be used"),
        Tile("alarms", str(len(opened)), f"open, and {len(alarms) - len(opened)} acknowledged"),
    )
    sentences = tuple(sentence(alarm) for alarm in opened)
    if not opened:
        sentences = ("No robot has changed beyond its usual scatter, its temperature and its motions.",)
    warnings = ("SIMULATED data.",) if simulated else ()
    return Headline(verdict, title, sentences, tiles, warnings)


def sentence(alarm: Alarm) -> str:
    """What an alarm says, in a sentence."""
    joints = f"joint {', '.join(map(str, alarm.joints))}" if alarm.joints else "the whole robot"
    what = alarm.effect or "an unknown effect"
    verb = "has grown" if alarm.kind == "growing" else "has been there"
    depends = f"; it depends on {' and '.join(alarm.depends_on)}" if alarm.depends_on else ""
    return f"{alarm.robot}: {what} on {joints} {verb} since {alarm.since}{depends}."


def _glance(nights: Sequence[Nights], failed: Sequence[Row], alarms: Sequence[Alarm]) -> ReportSection:
    dated: list[tuple[str, datetime]] = [
        (row["robot"], row["start"].replace(tzinfo=None)) for row in failed if row["robot"] and row["start"]
    ]
    caption = "Each recording, coloured by whether its robot had changed by then."
    plot = Plot("glance", figures.glance(nights, dated, alarms), caption)
    return ReportSection("glance", "At a glance", (plot,))


def _alarms(alarms: Sequence[Alarm], series: Sequence[Series], store: Store) -> ReportSection:
    if not alarms:
        return ReportSection("alarms", "Alarms", (Text(("There are none.",)),))
    return ReportSection(
        "alarms", "Alarms", tuple(_card(index, alarm, series, store) for index, alarm in enumerate(alarms))
    )


def _card(index: int, alarm: Alarm, series: Sequence[Series], store: Store) -> Card:
    names = alarm.shown_by[:_MAX_SHOWN]
    shown = [each for each in series if each.nights.robot == alarm.robot and each.name in names]
    plot = Plot(
        f"alarm-{index}",
        figures.trends(shown, (), [alarm]),
        "What shows it best, with 95 % intervals, and the date with its interval. Symbols tell motions apart.",
    )
    paths = [Fold("Recordings that were diagnosed together", (Notes((*alarm.before, *alarm.after)),))]
    commands = (
        f"ident diagnose {' '.join(alarm.after)}",
        f"ident fleet ack {alarm.id} --store {store.folder}",
    )
    tags = (alarm.kind, alarm.origin, *(["acknowledged"] if alarm.acknowledged else []))
    blocks: tuple[ReportBlock, ...] = (Text(tuple(_explanation(alarm))), plot, *paths, Code(commands))
    return Card(f"{alarm.robot}: {alarm.effect or 'unknown effect'}", tags, blocks)


def _explanation(alarm: Alarm) -> Iterator[str]:
    first, last = alarm.since_ci95
    yield sentence(alarm) + (f" It began between {first} and {last} (95 %)." if first != last else "")
    yield f"{alarm.why}."
    if alarm.torque_share:
        yield f"What other parameters cannot imitate of it is {percent(alarm.torque_share)} of the torque."
    if alarm.confusable_with:
        yield f"These recordings cannot tell it from: {', '.join(alarm.confusable_with)}."
    if alarm.origin == "measurement":
        yield "It is an effect of drive, gain or sensor, not of the mechanics."
    if alarm.note:
        yield f"Note: {alarm.note}"
    yield f"Evidence against chance: e-value 10^{number(alarm.log10_e, 2)}; changed: {', '.join(alarm.shown_by)}."


def _robots(
    nights: Sequence[Nights], series: Sequence[Series], floors: Sequence[Series], alarms: Sequence[Alarm]
) -> ReportSection:
    folds = []
    for index, each in enumerate(nights):
        shown, floor = (
            [quantity for quantity in kind if quantity.nights.robot == each.robot] for kind in (series, floors)
        )
        of_robot = [alarm for alarm in alarms if alarm.robot == each.robot]
        plot = Plot(
            f"robot-{index}",
            figures.trends(shown, floor, of_robot),
            "Parameters of the base model and error of each joint, fitted to each recording alone, with 95 % "
            "intervals. Symbols tell motions apart.",
        )
        folds.append(Fold(f"{each.robot}: {len(each.keys)} recordings", (plot,), open=len(nights) == 1))
    return ReportSection("robots", "Robots", tuple(folds) or (Text(("No recording can be used.",)),))


def _failed(failed: Sequence[Row]) -> ReportSection:
    rows = tuple((row["path"], row["reason"]) for row in sorted(failed, key=lambda row: str(row["path"])))
    return ReportSection(
        "failed", "Recordings that cannot be used", (ResultTable(("file", "reason"), rows, words=(0, 1)),)
    )


def _reproduce(content: FleetFile, store: Store) -> ReportSection:
    commands = (
        f"ident fleet {' '.join(content.folders)} --store {store.folder}",
        f"ident fleet report --store {store.folder} -o fleet.html",
    )
    text = Text(
        (f"Settings and method: {content.settings}. All figures are in {store.folder}/recordings/*.parquet.",)
    )
    return ReportSection("reproduce", "Reproduce", (Code(commands), text))
