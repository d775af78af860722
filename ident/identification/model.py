"""An identified model as an object: torque, voltage and inertia for any motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from ident.dynamics.effects.base import Effect
from ident.dynamics.inverse_dynamics import InverseDynamics
from ident.dynamics.motion import Motion, inertia_matrix
from ident.dynamics.torque_map import voltage_from_torque
from ident.identification import model_file
from ident.identification.identify import Identification
from ident.identification.model_file import FittedParameter, ModelFile
from ident.identification.prediction import structure_of
from recordings.errors import BadInput, expect
from recordings.files import check_new
from recordings.frames import data_frame
from recordings.importing.in_memory import real_array
from recordings.notebook import cell_progress, html_table
from recordings.reader import Source
from recordings.recording import Floats, Recording
from recordings.rig import Axis, Rig

if TYPE_CHECKING:
    from ident.export.losses import Carried

_NEWTON_STEPS = 20
"""Most steps to the acceleration that belongs to a torque."""
_CONVERGED = 1e-10
"""Relative change of the acceleration in the last of them."""


@dataclass(frozen=True, eq=False, repr=False)
class Model:
    """An identified model: a mechanism with effects, and the values of their parameters.

    Positions are those that the encoders report. Arrays are time-first, (n, dof), in SI units: [rad], [rad/s],
    [rad/s^2] and [N m] for a revolute joint, [m], [m/s], [m/s^2] and [N] for a prismatic one.
    """

    file: ModelFile
    """Content of the model file, with the parameters, their intervals, and what they were fitted to."""
    library: Mapping[str, Effect]
    """Effects by name, among them those of the model."""
    identification: Identification | None = None
    """The fit with its data; None for a model that was loaded, or diagnosed."""
    recording: Recording | None = None
    """The first one of the fit, or of the diagnosis; None for a model that was loaded."""

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects that were added to the mechanism, in this order."""
        return self.file.effects

    @property
    def parameters(self) -> dict[str, FittedParameter]:
        """The k identified parameters by name: value, unit, ci95, std, ...; those found by a search come last."""
        return {parameter.name: parameter for parameter in (*self.file.parameters, *self.file.searched)}

    @property
    def covariance(self) -> Floats:
        """(k, k) covariance of the errors of `parameters` due to noise; NaN where the data do not determine it."""
        assessment, std = self.file.assessment, [np.nan if x.std is None else x.std for x in self.parameters.values()]
        correlation = np.array(assessment.correlation if assessment else (), float)
        known = len(correlation)
        result = np.full((len(self.parameters),) * 2, np.nan)
        result[:known, :known] = correlation * np.outer(std[:known], std[:known])
        return result

    def to_frame(self) -> Any:
        """`parameters` as a pandas.DataFrame, one row each.

        Raises:
            BadInput: pandas is not installed.
        """
        found = self.parameters.values()
        columns = {name: [getattr(each, name) for each in found] for name in ("value", "unit", "std", "meaning")}
        limits = zip(*(each.ci95 or (np.nan, np.nan) for each in found), strict=True)
        return data_frame(columns | dict(zip(("ci95_low", "ci95_high"), limits, strict=True)), list(self.parameters))

    def __repr__(self) -> str:
        """One line: mechanism, effects, and the error."""
        data, judged = ("held out", self.file.validate_) if self.file.validate_ else ("training", self.file.train)
        errors = ", ".join(f"{rms:.3g}" for rms in judged.fitted.rms)
        return f"<Model {self.file.mechanism}: {', '.join(self.effects) or 'no effects'}; RMS {errors} N m {data}>"

    def __str__(self) -> str:
        """That line, the verdict on the residual, and a line for each thing that speaks against the model."""
        test, assessment = self.file.residual_test, self.file.assessment
        verdict, warnings = [test.sentence] if test else [], assessment.warnings if assessment else ()
        return "\n".join([repr(self), *verdict, *(warning.line for warning in warnings)])

    def _repr_html_(self) -> str:
        """Its errors as a table below the verdict, for a notebook."""
        test, judged = self.file.residual_test, {"training": self.file.train, "held out": self.file.validate_}
        errors: dict[str, tuple[float | None, ...]] = {name: each.fitted.rms for name, each in judged.items() if each}
        errors |= {"noise floor": test.noise_rms} if test else {}
        rows = [(name, *("" if x is None else f"{x:.3g}" for x in rms)) for name, rms in errors.items()]
        return html_table(test.sentence if test else repr(self), ("RMS error", *self.file.joints), rows)

    def save(self, path: str | Path, *, force: bool = False) -> None:
        """Write the model file `path`; force: replace an existing one.

        Raises:
            BadInput: the file exists and `force` is False, cannot be written, or is named like a recording.
        """
        if Path(path).suffix == ".mcap":
            raise BadInput(f"{path}: a model's name expected, a recording's (.mcap) found; give it another ending")
        check_new(Path(path), force)
        try:
            model_file.save(self.file, Path(path))
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise BadInput(f"model file {path} cannot be written: {reason}; choose another place") from None

    def plot(self, on: Source | str | None = None) -> Any:
        """A Plotly figure of measured and computed torque and of the residual over time.

        on: recording that is compared with; None: `recording`.

        Raises:
            BadInput: there is no recording, or it cannot be used.
        """
        import ident
        from ident.output.figures.torque import over_time

        return over_time({"model": ident.compare(self, self._compared(on))}, 0)

    def report(
        self,
        path: str | Path,
        on: Source | str | Sequence[Source | str] | None = None,
        *,
        validate: Source | str | Sequence[Source | str] | None = None,
        diagnose: bool = True,
        force: bool = False,
    ) -> None:
        """Write the page of `ident report`: where this model fails, and which effects are missing.

        path: the HTML file; force: replace an existing one.
        on: recordings that it is compared with; None: `recording`.
        validate: recordings that no fit uses.
        diagnose: whether missing effects are searched, which takes as long as `ident.diagnose`.

        Raises:
            BadInput: the file exists and `force` is False, or a recording cannot be used.
        """
        from ident.basics.arguments import sources
        from ident.output.report import contents, page

        check_new(Path(path), force)
        with TemporaryDirectory() as folder, cell_progress() as show:
            saved = Path(folder) / "model.json"
            self.save(saved)
            recordings, held_out = sources(self._compared(on), "on", least=1), sources(validate, "validate")
            request = contents.ReportRequest((saved,), recordings, held_out, (), diagnose)
            page.write(contents.gather(request, show, self.library), Path(path))

    def _compared(self, on: Any) -> Any:
        """The recordings `on` which the model is looked at, or that of the fit."""
        if on is None and self.recording is None:
            raise BadInput("on: a recording expected, none found, as the model was loaded; give one")
        return self.recording if on is None else on

    def export(
        self,
        target: str,
        out: str | Path,
        *,
        on: Source | str | None = None,
        precision: Literal["double", "float"] = "double",
        settings: Mapping[str, Any] | None = None,
        force: bool = False,
    ) -> Carried:
        """Write the model for a controller or a simulator, as `ident export`, which lists the targets, does.

        out: the file, or the folder of C; force: replace an existing one.
        on: recording along which tests and losses are computed; None: `recording`, or fig5a.
        settings: of the target, as `--set`: {"prefix": "left", "smooth_velocity": 0.01}.

        Returns:
            The effects that are carried, and those that are not, each with the reason.

        Raises:
            BadInput: there is no such target, the model does not suit it, the motion cannot be used, or `out` exists
                and `force` is False.
        """
        from ident.export import exporting

        expect(str | Path, "a path", out=out)
        path = exporting.motion(self, Path(on) if isinstance(on, str) else on or self.recording)
        check_new(Path(out), force)
        return exporting.export(self, target, Path(out), path, precision, settings)

    def torque(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        dt: float | None = None,
        t: ArrayLike | None = None,
        temperature: ArrayLike | None = None,
    ) -> Floats:
        """Torque (n, dof) that a motion takes at the motors: Eq. (26), with all effects of the model.

        Effects on what the drives report (gain, exponent, dead band, saturation, delay) belong to `voltage`. Effects
        with a memory (`stepped`) take the rows as instants that follow each other, and begin settled in the first.

        q, qd, qdd: (n, dof) position, velocity, acceleration.
        dt: time from row to row [s], for effects that remember what was before.
        t: (n,) time since the run began [s], for effects that change with it.
        temperature: (n, dof) temperature of the drives [degC], for effects that depend on it.

        Raises:
            BadInput: an array has another shape, or an effect needs what is not given.
        """
        return self.dynamics.torque(self.dynamics.inputs(*self._given(q, qd, qdd, dt, t, temperature)))

    def terms(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        dt: float | None = None,
        t: ArrayLike | None = None,
        temperature: ArrayLike | None = None,
    ) -> dict[str, Floats]:
        """Torque by its cause, (n, dof) each: the parts add up to `torque`.

        Of the mechanism, Eqs. (26)-(29): `inertia` of each joint itself (the diagonal of D), `inertia_coupling` (the
        rest of D), `coriolis` (with centrifugal forces), `gravity`, `viscous` and `coulomb` friction. Then each
        effect by its name, as `rod_inertia`; where one occurs several times, `cogging#2`. An effect on encoders or
        geometry has the torque that its correction changes; one on what the drives report has none.

        Arguments and errors: as `torque`.
        """
        given = self._given(q, qd, qdd, dt, t, temperature)
        return self.dynamics.terms_with_corrections(lambda dynamics: dynamics.inputs(*given))

    def voltage(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        dt: float | None = None,
        t: ArrayLike | None = None,
        temperature: ArrayLike | None = None,
    ) -> Floats:
        """Operating voltage (n, dof) [V] that a motion takes, by the torque map and the effects between the two.

        Arguments and errors: as `torque`.
        """
        reported = self.dynamics.reported(self.dynamics.inputs(*self._given(q, qd, qdd, dt, t, temperature)))
        return voltage_from_torque(reported, self.file.torque)

    def acceleration(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        torque: ArrayLike,
        dt: float | None = None,
        t: ArrayLike | None = None,
        temperature: ArrayLike | None = None,
    ) -> Floats:
        """Acceleration (n, dof) at which the motion `q`, `qd` takes the `torque` (n, dof): the inverse of `torque`.

        Other arguments: as `torque`.

        Raises:
            BadInput: as `torque`; an effect has inner motion of its own (elasticity, backlash); or no acceleration
                takes this torque.
        """
        inner = [term.name for _, term, effect in self.dynamics.structure.signals if effect.offset and effect.report]
        if inner:
            raise BadInput(f"a model without inner motion expected, effect {inner[0]} found; fit one without it")
        wanted = real_array(torque, "torque")
        result = np.zeros_like(self._motion(q, qd, wanted).acceleration)

        def excess(acceleration: Floats) -> Floats:
            return self.torque(q, qd, acceleration, dt, t, temperature) - wanted

        for _ in range(_NEWTON_STEPS):  # two are enough but for friction that depends on the load
            error = excess(result)
            slopes = [excess(result + unit) - error for unit in np.eye(result.shape[1])]
            change = np.linalg.solve(np.stack(slopes, axis=2), error[:, :, None])[:, :, 0]
            result = result - change
            if np.abs(change).max(initial=0.0) <= _CONVERGED * max(1.0, np.abs(result).max(initial=0.0)):
                return result
        raise BadInput(
            "torque: one that an acceleration of this model takes expected, none found; check its friction"
        )

    def inertia(self, q: ArrayLike) -> Floats:
        """Inertia matrix D(q) (n, dof, dof) at positions `q` (n, dof), Eq. (27) [kg m^2, or kg].

        Raises:
            BadInput: `q` has another shape.
        """
        position = real_array(q, "q")
        at_rest = self._motion(position, np.zeros_like(position), np.zeros_like(position))
        inputs = self.dynamics.inputs(at_rest)
        return inertia_matrix(inputs.rigid_at, inputs.motion.position)

    @property
    def stepped(self) -> tuple[str, ...]:
        """Names of the effects with a memory, which are stepped through the rows of a motion."""
        return tuple(dict.fromkeys(term.name for term in self.dynamics.structure.terms if term.effect.memory))

    @cached_property
    def dynamics(self) -> InverseDynamics:
        """Model structure with the values of its parameters."""
        return InverseDynamics(*structure_of(self.file, rig_of(self.file), self.library))

    def _given(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        dt: float | None,
        t: ArrayLike | None,
        temperature: ArrayLike | None,
    ) -> tuple[Motion, float | None, Floats | None, Floats | None]:
        """Checked arguments of `InverseDynamics.inputs`."""
        motion = self._motion(q, qd, qdd)
        if dt is not None and not 0 < float(real_array(dt, "dt")) < np.inf:
            raise BadInput(f"dt, a time step above 0 s, expected, {dt!r} found")
        time, shape = _optional(t, "t", motion.position.shape[:1]), motion.position.shape
        return motion, dt, time, _optional(temperature, "temperature", shape)

    def _motion(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Motion:
        arrays = [real_array(x, name) for x, name in ((q, "q"), (qd, "qd"), (qdd, "qdd"))]
        dof = len(self.file.joints)
        if any(x.ndim != 2 or x.shape != arrays[0].shape or x.shape[1] != dof for x in arrays):
            shapes = ", ".join(str(x.shape) for x in arrays)
            raise BadInput(f"q, qd and qdd of shape (n, {dof}) expected, {shapes} found; give one row per instant")
        position, velocity, acceleration = arrays
        return Motion(position, velocity, acceleration, np.sign(velocity))


def _optional(x: ArrayLike | None, name: str, shape: tuple[int, ...]) -> Floats | None:
    if x is None:
        return None
    array = real_array(x, name)
    if array.shape != shape:
        raise BadInput(f"{name} of shape {shape} expected, {array.shape} found; give one value per instant")
    return array


def rig_of(file: ModelFile) -> Rig:
    """What of the rig a model file holds: mechanism, geometry or URDF, and torque map."""
    if file.mechanism == "delta":
        assert file.geometry is not None
        return Rig(name="model", geometry=file.geometry, torque=file.torque, payload=file.payload)
    if file.robot is not None:
        return Rig(name="model", mechanism="urdf", torque=file.torque, **dict(file.robot))
    weights = {parameter.name for parameter in file.parameters if parameter.name.startswith("G_")}
    axes = tuple(
        Axis(
            type="revolute" if unit == "N m" else "prismatic",
            gravity=bool(weights & {f"G_{number}", f"G_c{number}"}),
        )
        for number, unit in enumerate(file.effort_units, start=1)
    )
    return Rig(name="model", mechanism="axes", axes=axes, torque=file.torque, payload=file.payload)
