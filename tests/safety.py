"""Assertions about power: a failure is never looked at again."""


class Unsafe(AssertionError):
    """A drive kept power, or a recording was lost."""


def assert_safe(safe: bool, told: object = "") -> None:
    """Fail with `told`, and for good, unless it is safe."""
    if not safe:
        raise Unsafe(told)
