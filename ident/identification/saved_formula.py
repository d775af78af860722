"""The formula of an effect as data of a model file: it is parsed, never executed."""

import hashlib
from functools import partial
from typing import Any

from pydantic import Field

from ident.dynamics.effects import quantities
from ident.dynamics.effects.base import Additive, Effect, Friction, Quantity, SignatureAxis
from ident.dynamics.effects.formula import traced
from ident.dynamics.effects.validation import validation_error
from ident.dynamics.effects.written_formula import WrittenFormula, as_text
from recordings.config import ConfigSection
from recordings.errors import BadInput


class SavedQuantity(ConfigSection):
    """A parameter or a shape of the formula."""

    name: str
    unit: str
    meaning: str
    lower: float | None = None
    upper: float | None = None
    initial_guesses: tuple[float, ...] = ()

    def quantity(self) -> Quantity:
        """The quantity that it describes."""
        bounds = {key: value for key in ("lower", "upper") if (value := getattr(self, key)) is not None}
        return Quantity(
            name=self.name, unit=self.unit, meaning=self.meaning, initial_guesses=self.initial_guesses, **bounds
        )


class SavedFormula(ConfigSection):
    """An effect of the user whose torque is a formula."""

    columns: tuple[str, ...]
    """Torque per unit of each parameter, see `formula`."""
    parameters: tuple[SavedQuantity, ...]
    shapes: tuple[SavedQuantity, ...] = ()
    axis: SignatureAxis
    whole_robot: bool = False
    on_arm: bool = False
    replaces: Friction | None = None
    sentence: str
    digest: str = Field(pattern="^[0-9a-f]{64}$")
    """Of the columns, as sha256: another formula has another one."""

    def effect(self, name: str) -> Additive:
        """The effect `name` that it describes.

        Raises:
            BadInput: a column is no formula, or the description is incomplete.
        """
        effect = Additive(
            sentence=self.sentence,
            symptom="The residual follows the formula.",
            causes="not known",
            remedy="look at the part itself",
            axis=self.axis,
            formula=WrittenFormula(*self.columns),
            parameters=tuple(each.quantity() for each in self.parameters),
            shapes=tuple(each.quantity() for each in self.shapes),
            whole_robot=self.whole_robot,
            on_arm=self.on_arm,
            replaces=self.replaces,
        )
        if problem := validation_error(effect):
            raise BadInput(f"effect {name} of the model: {problem}; take the file as `ident` wrote it")
        return effect


def saved_formula(effect: Effect) -> SavedFormula | None:
    """The `effect` as data; None if it is more than a formula of the motion."""
    if not isinstance(effect, Additive) or effect.formula is None or not _is_formula(effect):
        return None
    columns = tuple(text for text in map(as_text, traced(effect.formula)) if text)
    if len(columns) < len(effect.parameters):
        return None
    return SavedFormula(
        columns=columns,
        parameters=tuple(map(_saved, effect.parameters)),
        shapes=tuple(map(_saved, effect.shapes)),
        **{key: getattr(effect, key) for key in ("axis", "whole_robot", "on_arm", "replaces", "sentence")},
        digest=hashlib.sha256("\n".join(columns).encode()).hexdigest(),
    )


def _is_formula(effect: Additive) -> bool:
    """Whether nothing but the formula makes its columns."""
    columns: Any = getattr(effect.columns, "__wrapped__", effect.columns)  # of a user's file, errors are caught
    return isinstance(columns, partial) and columns.func is quantities.columns


def _saved(quantity: Quantity) -> SavedQuantity:
    bounds = {key: value for key in ("lower", "upper") if abs(value := getattr(quantity, key)) < float("inf")}
    texts = {key: getattr(quantity, key) for key in ("name", "unit", "meaning", "initial_guesses")}
    return SavedQuantity(**texts, **bounds)
