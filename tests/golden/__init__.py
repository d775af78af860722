"""Golden results: the numbers that `ident` gave, kept, so that a change which should change none is seen to.

`python -m tests.golden compare` runs fit, compare and diagnose on the sample recordings and on six cases of
`benchmarks.hidden_effects`, and compares what they print with `kept/`. It uses the command lines only, so that it
outlives any change inside.

The numbers belong to one kind of processor and one set of library versions: other ones round otherwise, and a fit
magnifies that, so that at 1e-9 they may differ where nothing is wrong. `kept/made_with.json` says what they were made
with. On another machine, keep them anew from a commit that is known to be right, then compare:

    git worktree add ../before COMMIT
    python -m tests.golden keep --code ../before
    python -m tests.golden compare

Where a change is meant to change numbers: compare, look at what differs, then `python -m tests.golden keep`.
"""
