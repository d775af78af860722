"""A made-up fleet on the plant of `tests.foreign`, and how well `ident fleet` finds what happened to it.

`python -m benchmarks.fleet FOLDER --robots 3 --nights 12` makes the recordings, a quarter of a second each,
resumes where it ended, runs `ident fleet` on them, opens the sealed truth and prints the score.
"""
