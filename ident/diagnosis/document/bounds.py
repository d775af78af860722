"""Caution about parameters that no machine has, or hardly any: impossible signs and sizes, and unusual ones."""

from collections.abc import Iterator, Mapping

import numpy as np

from ident.diagnosis.document.document import ParameterValue

_SURE = "Impossible: {}. A missing effect takes this part, or the sign of a torque or an angle is reversed."
_UNCERTAIN = (
    "Impossible, though perhaps by chance: {}. These data determine it poorly: the interval has possible values."
)
_UNUSUAL = "Unusual: {}. Look at the part itself before you compensate it: another effect may be taken for it."


def bound_warnings(
    parameters: Mapping[str, ParameterValue], usual: Mapping[str, tuple[float, float]]
) -> Iterator[str]:
    """Yield sentences that list the parameters outside of their physical bounds, and those of unusual size.

    usual: by name, where hardware usually stays between two values, ends excluded.
    """
    listed: dict[str, list[str]] = {_SURE: [], _UNCERTAIN: [], _UNUSUAL: []}
    for name, parameter in parameters.items():
        value, (low, high) = parameter.value, usual.get(name, (-np.inf, np.inf))
        lower = -np.inf if parameter.lower is None else parameter.lower
        upper = np.inf if parameter.upper is None else parameter.upper
        if not lower <= value <= upper:
            first, last = parameter.interval or (-np.inf, np.inf)
            kind = _SURE if last < lower or first > upper else _UNCERTAIN
            bound = f"below {lower:g}" if value < lower else f"above {upper:g}"
        elif not low < value < high:
            kind, bound = _UNUSUAL, f"at most {low:g}" if value <= low else f"at least {high:g}"
        else:
            continue
        listed[kind].append(f"{name} = {parameter.in_words} is {bound}")
    yield from (sentence.format("; ".join(entries)) for sentence, entries in listed.items() if entries)
