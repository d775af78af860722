"""Failures that a second look treats in a way of their own."""


class Unsafe(AssertionError):
    """A drive kept power, or a recording was lost: never looked at again."""


class Mistimed(AssertionError):
    """Something came too late though the machine kept time: a second look from which nothing follows excuses it."""


def assert_safe(safe: bool, told: object = "") -> None:
    """Fail with `told`, and for good, unless it is safe."""
    if not safe:
        raise Unsafe(told)
