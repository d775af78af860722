"""Many recordings of many robots over months: what was identified in each, and what has changed since when.

`places` are folders and object stores. `walk` finds recordings, `recording_rows` turns one into rows, `engines` do so
for many (`update`), and `store` keeps them. `common_course` says what all robots do together, `series` makes time
series of the rows, `evidence` is what those of a robot have shown, and `follow` keeps it from night to night.
`discoveries` says which series changed, `cause` names the effect, and `alarms` is the result. `page` shows it.
"""

from importlib.util import find_spec

from recordings.errors import BadInput


def check_installed() -> None:
    """Raise BadInput if the package that keeps the store is missing."""
    if find_spec("pyarrow") is None:
        raise BadInput(
            "the store of a fleet needs the package pyarrow, which is not installed; install it with "
            "`pip install 'delta-workbench[fleet]'`"
        )
