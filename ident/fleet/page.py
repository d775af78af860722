"""The page of a fleet: at a glance, alarms with their evidence, every robot over time, and what cannot be used."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import pyarrow.compute as pc

from ident.fleet import figures
from ident.fleet.alarms import Alarm, FleetFile
from ident.fleet.evidence import RobotEvidence
from ident.fleet.follow import known
from ident.fleet.recording_rows import Row
from ident.fleet.series import day_of
from ident.fleet.store import Store
from ident.output.digits import number, percent
from ident.output.report.blocks import Card, Code, Drawings, Fold, Notes, ReportBlock, ReportSection, Text
from ident.output.report.headline import Headline, Tile
from ident.output.report.page import assembled, write_page
from ident.output.tables import ResultTable

Fleet = Mapping[str, RobotEvidence]
"""What each robot has shown, by its name."""
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
    fleet = known(store, content.settings)
    index = store.index()
    rows = index.filter(pc.equal(index["settings"], content.settings))
    failed = rows.filter(pc.equal(rows["status"], "failed")).to_pylist()
    alarms = sorted(content.alarms, key=lambda alarm: (alarm.acknowledged, alarm.robot, alarm.since))
    sections = [
        _glance(fleet, failed, alarms),
        _alarms(alarms, fleet, store),
        _robots(fleet, alarms),
        *([_failed(failed)] if failed else []),
        _reproduce(content, store),
    ]
    data = content.model_dump(mode="json", by_alias=True)
    simulated = bool(pc.any(rows["simulated"]).as_py())
    return assembled("Fleet", [str(store.folder)], _headline(fleet, failed, alarms, simulated), sections, data)


def _headline(fleet: Fleet, failed: Sequence[Row], alarms: Sequence[Alarm], simulated: bool) -> Headline:
    opened = [alarm for alarm in alarms if not alarm.acknowledged]
    count = sum(len(robot.days) for robot in fleet.values())
    verdict = "adequate"
    if opened:
        verdict = "missing-effect" if all(alarm.effect for alarm in opened) else "unknown-structure"
    plural = "s are" if len(opened) > 1 else " is"
    title = f"{len(opened)} alarm{plural} open" if opened else "No alarm is open"
    tiles = (
        Tile("robots", str(len(fleet)), "with recordings that can be used"),
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


def _glance(fleet: Fleet, failed: Sequence[Row], alarms: Sequence[Alarm]) -> ReportSection:
    dated = [(row["robot"], day_of(row["start"])) for row in failed if row["robot"] and row["start"]]
    caption = "All recordings, coloured by whether their robot had changed by then."
    return ReportSection("glance", "At a glance", (Drawings((figures.glance(fleet, dated, alarms),), caption),))


def _alarms(alarms: Sequence[Alarm], fleet: Fleet, store: Store) -> ReportSection:
    if not alarms:
        return ReportSection("alarms", "Alarms", (Text(("There are none.",)),))
    return ReportSection("alarms", "Alarms", tuple(_card(alarm, fleet, store) for alarm in alarms))


def _card(alarm: Alarm, fleet: Fleet, store: Store) -> Card:
    """An alarm, with what shows it and what to do as long as it is open."""
    blocks: list[ReportBlock] = [
        Text(tuple(_explanation(alarm))),
        Fold("Recordings that were diagnosed together", (Notes((*alarm.before, *alarm.after)),)),
    ]
    if not alarm.acknowledged:
        of_robot = fleet[alarm.robot].trends
        shown = {name: of_robot[name] for name in alarm.shown_by[:_MAX_SHOWN]}
        drawings = Drawings(
            figures.trends(shown, [alarm], intervals=True),
            "What shows it best, with 95 % intervals, and the date with its interval. Squares are other motions. "
            "Older dots are means of several nights.",
        )
        commands = (
            f"ident diagnose {' '.join(alarm.after)}",
            f"ident fleet ack {alarm.id} --store {store.folder}",
        )
        blocks = [blocks[0], drawings, blocks[1], Code(commands)]
    tags = (alarm.kind, alarm.origin, *(["acknowledged"] if alarm.acknowledged else []))
    return Card(f"{alarm.robot}: {alarm.effect or 'unknown effect'}", tags, tuple(blocks))


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


def _robots(fleet: Fleet, alarms: Sequence[Alarm]) -> ReportSection:
    folds = []
    for name, robot in fleet.items():
        drawings = Drawings(
            figures.trends(robot.trends, [alarm for alarm in alarms if alarm.robot == name]),
            "Parameters of the base model and error of each joint, fitted to each recording alone. Squares are other "
            "motions. Older dots are means of several nights.",
        )
        folds.append(Fold(f"{name}: {len(robot.days)} recordings", (drawings,), open=len(fleet) == 1))
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
        (f"Settings and method: {content.settings}. All figures are in {store.folder}/recordings/*/*.parquet.",)
    )
    return ReportSection("reproduce", "Reproduce", (Code(commands), text))
