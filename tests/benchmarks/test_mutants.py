"""Mutants: single changes that can be told from each other, and that the sources allow."""

import ast

from benchmarks.mutants import mutants_of, source_of

MODULE = '''"""A module."""
LIMIT = 0.5


def f(x: int, word: str = "a") -> bool:
    """Say whether."""
    if not word + "b":
        raise ValueError("1 and " + word)
    return min(x, 2) < LIMIT and x < LIMIT
'''


def test_each_mutant_changes_one_place_and_has_its_own_number() -> None:
    mutants = list(mutants_of("m.py", MODULE))
    assert (mutants[0].path, mutants[0].number) == ("m.py", "m.py:2:8:0")
    sources = [source_of(mutant, MODULE) for mutant in mutants]
    assert len({mutant.number for mutant in mutants}) == len(set(sources)) == len(mutants)
    for mutant, source in zip(mutants, sources, strict=True):
        before, after = (ast.unparse(ast.parse(text)).splitlines() for text in (MODULE, source))
        assert sum(old != new for old, new in zip(before, after, strict=True)) == 1, mutant.text


def test_operators_numbers_and_functions_are_changed_but_no_text() -> None:
    changes = {(mutant.before, mutant.after) for mutant in mutants_of("m.py", MODULE)}
    assert {("0.5", "1.0"), ("x < LIMIT", "x >= LIMIT"), ("min(x, 2)", "max(x, 2)"), ("2", "4")} <= changes
    assert not any("'" in before and not before.startswith(("if", "not")) for before, _ in changes)
