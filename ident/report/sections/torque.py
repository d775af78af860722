"""Torque measured against computed."""

from ident.figures import torque
from ident.report.blocks import Block, Fold, Plot, Section
from ident.report.material import Material


def section(material: Material) -> Section:
    """Every recording over time; the first one that was held out is open."""
    opened = len(material.request.recordings) if material.held_out else 0
    blocks: list[Block] = []
    for number, (group, place, found) in enumerate(material.predictions):
        dataset = found.dataset
        caption = (
            f"Measured and computed torque, and below it what is left, low-pass {dataset.bandwidth:g} Hz. Drag to "
            "zoom (all joints follow), double click for the whole recording."
        )
        plot = Plot(f"torque-{number + 1}", torque.over_time(group, place), caption)
        held = ", held out" if group is material.held_out else ""
        blocks.append(Fold(f"{dataset.recording.path.name}{held}", (plot,), open=number == opened))
    return Section("torque", "Torque: measured against model", tuple(blocks))
