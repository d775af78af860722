"""The file of what was tried, one line for a case or a pair of case and variant, and the table that it gives."""

import random
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.ablation.subjects import TODAY, Pair, Subject, Trial, VariantOutcome

_SAME = "="
"""In place of a text: that of today."""
_USED_CASES = 8
"""Cases on which a constant is tried whose nearness is not known."""
_TEXT = 400
"""Longest text in the file."""
_NAMES = 6
"""Cases that are listed in a line of the table."""


class Results:
    """Trials of one version of the diagnosis, kept in a file of columns that tabs separate.

    Columns: case, variant, seconds, score, outcome; in lines of today also the near variants and those of constants
    used otherwise, as the bits of hexadecimal numbers, in the order of the variants in the head.
    """

    def __init__(self, path: Path, sources: str, variants: Sequence[str]) -> None:
        self._path, self.variants = path, tuple(variants)
        self.today: dict[str, Trial] = {}
        self.tried: dict[tuple[str, str], Trial] = {}
        head = ["\t".join(["sources", sources]), "\t".join(["variants", *self.variants])]
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text("\n".join(head) + "\n", encoding="utf-8")
        text = path.read_text(encoding="utf-8")
        if not text.endswith("\n"):  # the last line was interrupted
            text = text[: text.rfind("\n") + 1]
            path.write_text(text, encoding="utf-8")
        lines = text.splitlines()
        if lines[:2] != head:
            raise SystemExit(f"{path}: results of the sources {sources} expected, others found; move the file away")
        for line in lines[2:]:
            self._keep(self._parsed(line.split("\t")))

    def add(self, trial: Trial) -> None:
        """Keep a trial, its text in one line."""
        text = " ".join(trial.outcome.text.split())[:_TEXT]
        trial = replace(trial, outcome=replace(trial.outcome, text=text))
        self._keep(trial)
        same = trial.variant != TODAY and trial.outcome == self.today[trial.case].outcome
        columns = [trial.case, trial.variant, f"{trial.seconds:g}", str(trial.outcome.score), _SAME if same else text]
        if trial.variant == TODAY:
            columns += [self._bits(trial.near), self._bits(trial.used)]
        with self._path.open("a", encoding="utf-8") as file:
            file.write("\t".join(columns) + "\n")

    def _keep(self, trial: Trial) -> None:
        if trial.variant == TODAY:
            self.today[trial.case] = trial
        else:
            self.tried[trial.case, trial.variant] = trial

    def _parsed(self, columns: Sequence[str]) -> Trial:
        case, variant, seconds, score, text, *bits = columns
        text = self.today[case].outcome.text if text == _SAME else text
        near, used = (self._set(each) for each in bits or ("0", "0"))
        return Trial(case, variant, float(seconds), VariantOutcome(text, int(score)), near, used)

    def _bits(self, chosen: Iterable[str]) -> str:
        return f"{sum(1 << self.variants.index(variant) for variant in chosen if variant in self.variants):x}"

    def _set(self, bits: str) -> frozenset[str]:
        number = int(bits, 16)
        return frozenset(variant for index, variant in enumerate(self.variants) if number >> index & 1)

    @property
    def seconds(self) -> float:
        """Time of the processor for all pairs."""
        return sum(trial.seconds for trial in self.tried.values())

    def near(self, variant: str) -> list[str]:
        """Cases that the `variant` comes near."""
        return [case for case, trial in self.today.items() if variant in trial.near]

    def used(self, variant: str) -> list[str]:
        """Cases in which its constant is used, and of which nobody knows whether the `variant` comes near."""
        return [case for case, trial in self.today.items() if variant in trial.used - trial.near]

    def pairs(self, variant: str, seed: int) -> list[str]:
        """Cases to try a `variant` on, in random order: all that it comes near, and some where it is used."""
        rng = random.Random(f"{seed} {variant}")
        near, used = sorted(self.near(variant)), sorted(self.used(variant))
        return rng.sample(near, len(near)) + rng.sample(used, min(_USED_CASES, len(used)))

    def todo(self, subjects: Sequence[Subject], seed: int) -> list[Pair]:
        """Pairs that were not tried, in random order: first one of each variant, then a second one of each."""
        by_name = {subject.name: subject for subject in subjects}
        order = random.Random(seed).sample(self.variants, len(self.variants))
        ranked = [(rank, case, variant) for variant in order for rank, case in enumerate(self.pairs(variant, seed))]
        return [
            Pair(by_name[case], variant)
            for _, case, variant in sorted(ranked, key=lambda entry: entry[0])
            if case in by_name and (case, variant) not in self.tried
        ]

    def table(self, seed: int) -> Iterator[str]:
        """Yield the lines of the table; variants that cannot matter to any case share the last line."""
        yield _row("variant", ("near", "used", "tried", "not tried", "changed", "better", "worse"), "needed by")
        idle = [variant for variant in self.variants if not (self.near(variant) or self.used(variant))]
        for variant in [each for each in self.variants if each not in idle]:
            trials = [trial for trial in self.tried.values() if trial.variant == variant]
            worse = [trial.case for trial in trials if self._gain(trial) < 0]
            numbers = (
                len(self.near(variant)),
                len(self.used(variant)),
                len(trials),
                sum((case, variant) not in self.tried for case in self.pairs(variant, seed)),
                sum(trial.outcome != self.today[trial.case].outcome for trial in trials),
                sum(self._gain(trial) > 0 for trial in trials),
                len(worse),
            )
            more = f" and {len(worse) - _NAMES} more" if len(worse) > _NAMES else ""
            yield _row(variant, numbers, ", ".join(worse[:_NAMES]) + more)
        yield f"in no case near or used: {', '.join(idle)}"

    def _gain(self, trial: Trial) -> int:
        return trial.outcome.score - self.today[trial.case].outcome.score


def _row(variant: str, cells: Iterable[object], names: str) -> str:
    return f"{variant:54}{''.join(f'{cell:>10}' for cell in cells)}  {names}".rstrip()
