"""A fitted model as the content of a file: parameters, range of motion, agreement with its data."""

from collections.abc import Sequence

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.data.samples import is_relative
from ident.dynamics.structure import ModelStructure
from ident.estimation.linear_fit import Fit
from ident.estimation.regression import Regression
from ident.identification.goodness_of_fit import goodness_of_fit
from ident.identification.model_file import (
    Agreement,
    FitMethod,
    FittedParameter,
    ModelFile,
    MotionRange,
    Preprocessing,
    recording_source,
)
from ident.identification.prediction import effect_terms, searched_parameters
from ident.uncertainty.assessment import Assessment, ParameterUncertainty
from ident.uncertainty.time_delay import delays
from recordings.recording import Floats


def model_of(
    train: Sequence[Regression],
    structure: ModelStructure,
    x: Floats,
    result: Fit,
    method: FitMethod,
    preprocessing: str,
    assessed: tuple[Assessment | None, Sequence[ParameterUncertainty]],
    agreements: tuple[Agreement, Agreement | None],
) -> ModelFile:
    """Describe a fitted model as a file.

    assessed: of the whole, of each linear parameter, and of those that were searched, where known.
    agreements: with training and validation data.
    """
    rig, prepared = train[0].prepared.recording.rig, train[0].prepared
    effects, cutoff, count = effect_terms(structure, x), prepared.cutoff, len(result.parameters)
    return ModelFile(
        mechanism=rig.mechanism,
        effects=tuple(term.name for term in effects),
        terms=effects,
        joints=rig.joint_names,
        effort_units=rig.effort_units,
        geometry=rig.geometry if rig.mechanism == "delta" else None,
        robot=rig.chain if rig.mechanism == "urdf" else None,
        payload=rig.payload,
        torque=rig.torque,
        relative=is_relative(prepared.recording),
        parameters=_parameters(structure, result, assessed[1][:count]),
        searched=searched_parameters(structure, x, assessed[1][count:]),
        method=method,
        preprocessing=Preprocessing(
            name=preprocessing,
            bandwidth=prepared.bandwidth,
            rate=prepared.rate,
            cutoff=cutoff.sentence() if cutoff else None,
            delays=delays(train, result.parameters) if assessed[0] else None,
        ),
        motion_range=_motion_range([each.prepared for each in train]),
        train=agreements[0],
        validate=agreements[1],
        assessment=assessed[0],
    )


def _motion_range(train: Sequence[PreparedRecording]) -> MotionRange:
    """Range of the motion in the usable rows."""

    def limits(name: str) -> tuple[tuple[float, float], ...]:
        rows = np.concatenate([np.where(each.usable, getattr(each.motion, name), np.nan) for each in train])
        lowest, highest = np.fmin.reduce(rows).tolist(), np.fmax.reduce(rows).tolist()
        return tuple(zip(lowest, highest, strict=True))

    return MotionRange(position=limits("position"), velocity=limits("velocity"), acceleration=limits("acceleration"))


def _parameters(
    structure: ModelStructure, result: Fit, uncertainties: Sequence[ParameterUncertainty]
) -> tuple[FittedParameter, ...]:
    return tuple(
        FittedParameter(
            name=parameter.name,
            value=float(value),
            unit=parameter.unit,
            lower=float(lower),
            upper=float(upper),
            at_bound=at_bound,
            paper_value=float(parameter.paper_sign * value),
            meaning=parameter.meaning,
            **uncertainty.model_dump(),
        )
        for parameter, value, (lower, upper), at_bound, uncertainty in zip(
            structure.linear_parameters, result.parameters, result.bounds, result.at_bound, uncertainties, strict=True
        )
    )


def agreement(
    recordings: Sequence[PreparedRecording], measured: Sequence[Floats], computed: Sequence[Floats]
) -> Agreement:
    """Agreement of the torques `measured` and `computed` (m, dof) of all `recordings`; NaN is skipped."""
    torque = np.concatenate(measured)
    nominal = [each.nominal for each in recordings if each.nominal is not None]
    paths = {each.recording.path: each.recording for each in recordings}
    return Agreement(
        recordings=tuple(map(recording_source, paths.values())),
        fitted=goodness_of_fit(torque, np.concatenate(computed)),
        nominal=goodness_of_fit(torque, np.concatenate(nominal)) if nominal else None,
    )
