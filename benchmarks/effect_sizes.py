"""Tabulate the strength of each hidden effect of the simulated plant for given sizes, on two robots along fig5a.

`python -m benchmarks.effect_sizes [EFFECT...]` takes one or two minutes per robot for all effects.
"""

import sys

import numpy as np

from drivers.simulated.config import ROBOTS, load_sim
from drivers.simulated.effect import discover, library, out_of_library
from drivers.simulated.hidden import draw_effect
from drivers.simulated.sizing import EffectSizer
from recordings.errors import BadInput
from recordings.rig import Rig, Voltage, simulated_rig

SIZES = (0.01, 0.03, 0.10)
_SEED = 1


def rig() -> Rig:
    """Simulated rig that reports commanded voltages: some effects are not visible in true motor voltages."""
    drives = (drive.model_copy(update={"voltage": Voltage(kind="command")}) for drive in simulated_rig().drives)
    return simulated_rig().model_copy(update={"drives": tuple(drives)})


def row(sizer: EffectSizer, name: str) -> str:
    """Table row of the effect `name`: its strength for each of SIZES; in brackets: for the nearest possible size."""
    effect = draw_effect(np.random.default_rng(_SEED), (name,))
    cells = []
    for wanted in SIZES:
        try:
            scaled, size = sizer.nearest(effect, wanted)
        except BadInput as error:
            return f"| `{name}` | {error} |"
        strength = f"{scaled.model_dump()[scaled.strength()]:.3g}"
        reached = abs(size / wanted - 1) < 0.1
        cells.append(strength if reached else f"({strength}: {100 * size:.1f} %)")
    shape = {key: f"{value:.3g}" for key, value in effect.model_dump(exclude={"joints", effect.strength()}).items()}
    shapes = ", ".join(f"{key} = {value}" for key, value in shape.items())
    joints = "robot" if effect.whole_robot else ", ".join(map(str, effect.joints))
    return f"| `{name}` | {joints} | {_strength_range(name)} | {' | '.join(cells)} | {shapes} |"


def _strength_range(name: str) -> str:
    kind = discover()[name]
    field = kind.model_fields[kind.strength()]
    unit = field.json_schema_extra["unit"] if isinstance(field.json_schema_extra, dict) else ""
    lowest = next(bound.ge for bound in field.metadata if hasattr(bound, "ge"))
    return f"{kind.strength()} {lowest:g}…{kind.largest():g} {unit}"


def main() -> None:
    """Print one table per robot."""
    names = sys.argv[1:] or [*library(), *out_of_library()]
    for robot in ("heavy", "light"):
        sizer = EffectSizer(rig(), load_sim(ROBOTS / f"{robot}.toml"))
        print(f"\n{robot} robot: strength for a size of\n")
        print("| effect | joints | strength | " + " | ".join(f"{100 * size:g} %" for size in SIZES) + " | shape |")
        print("|---|---|---|---|---|---|---|")
        for name in names:
            print(row(sizer, name), flush=True)


if __name__ == "__main__":
    main()
