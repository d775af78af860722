"""Golden results: stored numbers of `ident`, to verify that a change does not alter results.

`python -m tests.golden compare` runs fit, compare and diagnose on the sample recordings and on six cases of
`benchmarks.hidden_effects`, and compares their output with `kept/`. It uses only the command lines, so that it does
not depend on internals.

The numbers depend on the processor and the library versions: different rounding is amplified by a fit and may exceed
1e-9 where nothing is wrong. `kept/made_with.json` lists the processor and versions of the stored numbers. On another
machine, store them again from a commit that is known to be right, then compare:

    git worktree add ../before COMMIT
    python -m tests.golden keep --code ../before
    python -m tests.golden compare

If a change is meant to alter numbers: compare, review the differences, then `python -m tests.golden keep`.
"""
