"""`python -m benchmarks.hidden_effects.traps [--seeds N]`: recordings of one axis that invite false names.

Nothing that is hidden in most of them is in the library that diagnoses them: none of the effects in `FALSE` may be
named. Of those in `HIDDEN` it is, and nothing else may be named.
"""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import click

from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose
from ident.diagnosis.document import verdict
from ident.diagnosis.document.document import Document
from ident.dynamics.effects.library import library
from tests.foreign import traps
from tests.foreign.pairs import TRAIN, VALIDATE

FALSE = ("amplifier_saturation", "encoder_eccentricity", "thermal_drift")
"""Effects that such recordings were blamed on."""
TRUE = ("axis_weight", "position_dependent_friction", "position_torque", "power_law_friction")
"""Effects that would be right, or nearly so: they are left out of the library where it has them."""
HIDDEN: dict[traps.Kind, tuple[str, ...]] = {
    "heavy_axis": ("axis_weight",),
    "turned_motor": ("torque_offset",),
    "slow_turns": ("axis_weight", "torque_offset"),
}
"""Effects that are right, and that the library has."""


def diagnose_trap(kind: traps.Kind, seed: int) -> Document:
    """Record and diagnose a trap."""
    effects = {name: effect for name, effect in library().items() if kind in HIDDEN or name not in TRUE}
    with TemporaryDirectory() as name:
        folder = Path(name)
        traps.make(folder, kind, seed)
        held_out = [folder / VALIDATE] if (folder / VALIDATE).exists() else []
        return verdict.to_document(diagnose([folder / TRAIN], held_out, effects, DiagnosisOptions()))


def false_names(kind: traps.Kind, document: Document) -> list[str]:
    """Effects in the findings of which this trap has nothing."""
    if kind not in HIDDEN:
        return [finding.effect for finding in document.findings if finding.effect in FALSE]
    named = [(finding.effect, {finding.effect, *finding.confusable_with}) for finding in document.findings]
    return [effect for effect, group in named if not group.intersection(HIDDEN[kind])]


@click.command()
@click.option("--seeds", default=20, show_default=True, help="Number of recordings of each kind.")
@click.option("--only", type=click.Choice(traps.KINDS), multiple=True, help="Only traps of this kind.")
def main(seeds: int, only: tuple[traps.Kind, ...]) -> None:
    """Diagnose traps of every kind, and print what was named. Exit code 1 if anything false was believed."""
    believed = 0
    for kind in only or traps.KINDS:
        documents = list(_with_progress(kind, seeds))
        wrong = [document for document in documents if false_names(kind, document)]
        believed += len(wrong)
        named = sum(bool(document.findings) for document in documents)
        click.echo(f"{kind:20} {seeds} traps, {len(wrong)} with a false name, {named} with any name")
    raise SystemExit(1 if believed else 0)


def _with_progress(kind: traps.Kind, seeds: int) -> Iterator[Document]:
    for seed in range(seeds):
        document = diagnose_trap(kind, seed)
        names = ", ".join(finding.effect for finding in document.findings)
        click.echo(f"  {kind} {seed}: {document.verdict} {names}", err=True)
        yield document


if __name__ == "__main__":
    main()
