"""The result of a diagnosis as a user receives it: the document, and the model with all effects found."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ident.data.samples import is_relative
from ident.diagnosis.diagnosis import Diagnosis, DiagnosisOptions, StatusCallback, diagnose
from ident.diagnosis.document.document import Document, FindingEntry, FormulaEntry, StepEntry, Verdict
from ident.diagnosis.document.formula import with_formula
from ident.diagnosis.document.verdict import parameter_intervals, to_document
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.ripple.ripple import Ripple
from ident.diagnosis.unknown.residual_test import UnexplainedResidual, residual_test
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import ParameterEntry
from ident.estimation.linear_fit import SEARCH_FACTOR, Fit, search_region
from ident.estimation.problem import Estimate
from ident.estimation.regression import linearize
from ident.identification.fit_warnings import with_warnings
from ident.identification.model import Model
from ident.identification.model_description import agreement, model_of
from ident.identification.model_file import Agreement, FitMethod, FittedParameter, ModelFile
from ident.identification.prediction import effect_terms
from ident.uncertainty.assessment import ParameterUncertainty, assess, interval_or_none, number_or_none
from ident.uncertainty.sensitivity import Sensitivity
from recordings.files import check_new
from recordings.notebook import html_table
from recordings.reader import Source
from recordings.recording import Bools, Floats

METHOD = "wls"
"""The estimator that a diagnosis uses: least squares, weighted by the noise."""


@dataclass(frozen=True, eq=False, repr=False)
class DiagnosisResult:
    """A diagnosis of recordings."""

    document: Document
    """What `ident diagnose --json` prints."""
    diagnosis: Diagnosis
    """Models, residuals and data behind the document."""
    options: DiagnosisOptions

    def __getstate__(self) -> dict[str, Any]:
        """Pickle the last model as it is; what else is behind the document is computed again."""
        return {"document": self.document, "diagnosis": self.diagnosis, "options": self.options, "model": self.model}

    def __repr__(self) -> str:
        """One line: the verdict, and the effects found."""
        found = ", ".join(f"{each.effect} on joints {', '.join(map(str, each.joints))}" for each in self.findings)
        return f"<DiagnosisResult {self.verdict}: {found or 'no effect'}>"

    def __str__(self) -> str:
        """What a person would say first, and the held-out error of each joint, from the first model to the last."""
        return "\n".join([self.document.sentence, *self.document.error_lines])

    def _repr_html_(self) -> str:
        """The held-out error of each model as a table below the verdict's sentence, for a notebook."""
        errors = [*(step.held_out_rms for step in self.document.steps), self.document.noise_rms]
        named = zip((*self.document.labels, "noise floor"), errors, strict=True)
        rows = [(name, *(f"{rms:.3g}" for rms in each)) for name, each in named]
        return html_table(self.document.sentence, ("held-out RMS error", *self.document.joints), rows)

    def plot(self) -> Any:
        """A Plotly figure of the error after each step."""
        from ident.output.figures.steps import error_steps

        return error_steps(self.document)

    @property
    def verdict(self) -> Verdict:
        """adequate, missing-effect, unknown-structure or undetermined."""
        return self.document.verdict

    @property
    def findings(self) -> tuple[FindingEntry, ...]:
        """The effects found, in the order in which they were added."""
        return self.document.findings

    def as_json(self) -> dict[str, Any]:
        """The document as `ident diagnose --json` prints it."""
        return self.document.as_json()

    def propose(self, path: Path | str | None = None, *, force: bool = False) -> FormulaEntry | None:
        """A formula for what is left, or in place of an effect with knots; None if held-out rows confirm none.

        path: the effect file to write; none is written where nothing is confirmed. force: replace an existing one.

        Raises:
            BadInput: the file exists and `force` is False.
        """
        if path:
            check_new(Path(path), force)
        return self.with_formula(path).document.remaining.formula

    def with_formula(self, path: Path | str | None = None) -> "DiagnosisResult":
        """The result with the formula of `propose` in its document."""
        document, law = with_formula(self.diagnosis, self.document)
        if path and law:
            Path(path).write_text(law, encoding="utf-8")
        return replace(self, document=document)

    @cached_property
    def model(self) -> Model:
        """The last model of the document, with all effects found: the same values, intervals and errors."""
        split, file = self.diagnosis.model.split, _diagnosed_model(self.diagnosis, self.document.steps[-1])
        return Model(file, self.diagnosis.library, recording=split.recordings[split.train_indices[0]].recording)


def diagnosed(
    files: Sequence[Source],
    validate: Sequence[Source],
    effects: Mapping[str, Effect],
    options: DiagnosisOptions,
    progress: StatusCallback,
    model: ModelFile | None = None,
) -> DiagnosisResult:
    """Diagnose the recordings `files` with a library of `effects`, see `ident.diagnose`.

    model: whose effects are the start; None: the base model.
    """
    diagnosis = diagnose(files, validate, effects, options, progress, model)
    return DiagnosisResult(to_document(diagnosis), diagnosis, options)


def _diagnosed_model(diagnosis: Diagnosis, last: StepEntry) -> ModelFile:
    """The last model of a `diagnosis` with the lines above the low-pass, and the errors of the `last` step."""
    file = model_file(diagnosis.model, diagnosis.unexplained, ripple=diagnosis.ripple)
    ripple, structure, first = diagnosis.ripple, diagnosis.ripple.structure, len(diagnosis.model.solution.x)
    terms = effect_terms(structure, ripple.x)
    values = zip(structure.parameters[first:], ripple.x[first:].tolist(), ripple.half_widths.tolist(), strict=True)
    lines = [(entry.linear, _of_line(entry, value, width)) for entry, value, width in values]
    linear = [line for is_linear, line in lines if is_linear]
    searched = [line for is_linear, line in lines if not is_linear]
    count, others = len(file.parameters), len(file.searched)
    behind = count + len(linear)
    known = [*range(count), *range(behind, behind + others)]
    correlation = np.full((behind + others + len(searched),) * 2, np.nan)
    assert file.validate_ is not None
    assert file.assessment is not None
    correlation[np.ix_(known, known)] = np.array(file.assessment.correlation, float)
    return file.model_copy(
        update={
            "effects": tuple(term.name for term in terms),
            "terms": terms,
            "data_problems": diagnosis.data_problems,
            "parameters": (*file.parameters, *linear),
            "searched": (*file.searched, *searched),
            "assessment": file.assessment.model_copy(update={"correlation": _written(correlation)}),
            "train": _with_errors(file.train, last.train_rms),
            "validate_": _with_errors(file.validate_, last.held_out_rms),
        }
    )


def _of_line(entry: ParameterEntry, value: float, width: float) -> FittedParameter:
    """A parameter of a line above the low-pass; `width`: half its 95 % interval."""
    interval = value - width, value + width
    return FittedParameter(
        name=entry.name,
        value=value,
        unit=entry.unit,
        lower=-SEARCH_FACTOR * abs(value),
        upper=SEARCH_FACTOR * abs(value),
        at_bound=False,
        paper_value=value,
        ci95=interval,
        shape_ci95=interval,
    )


def _with_errors(stated: Agreement, rms: tuple[float, ...]) -> Agreement:
    """The agreement with the RMS errors that a document states, which may reach above the low-pass."""
    return stated.model_copy(update={"fitted": replace(stated.fitted, rms=rms)})


def model_file(
    model: FittedModel, unexplained: UnexplainedResidual, diagnosed: bool = True, ripple: Ripple | None = None
) -> ModelFile:
    """Describe `model` with its `unexplained` residual as a file.

    diagnosed: whether a diagnosis has searched that residual for effects; ripple: what it found above the low-pass.
    """
    split, solution, uncertainty = model.split, model.solution, model.uncertainty
    structure, x, linear = solution.structure, solution.x, solution.structure.linear
    regressions = [linearize(split.recordings[i], structure, x) for i in split.train_indices]
    prepared = regressions[0].prepared
    rows, torques = zip(*(regression.rows() for regression in regressions), strict=True)
    bounds = search_region(structure.linear_parameters, np.concatenate(rows), np.concatenate(torques))
    fit = Fit(Estimate(x[linear], solution.loss, np.array([solution.loss])), bounds, solution.row_count)
    assessment, single = assess(
        regressions, fit, structure, METHOD, Sensitivity(None, ()), is_relative(prepared.recording)
    )
    # The model's own intervals also hold what quantization does to parameters, and the errors of what was searched.
    totals, shapes = parameter_intervals(model, ripple or Ripple(model))
    order = np.concatenate([np.flatnonzero(linear), np.flatnonzero(structure.searched)])
    finite = np.isfinite(shapes[structure.searched, 0])
    searched = [ParameterUncertainty(status="identifiable" if known else None) for known in finite]
    own = zip((*single, *searched), totals[order], shapes[order], uncertainty.std[order], strict=True)
    uncertainties = [
        each.model_copy(
            update={
                "ci95": interval_or_none(total),
                "shape_ci95": interval_or_none(shape),
                "std": number_or_none(std),
                "degrees_of_freedom": None,
            }
        )
        for each, total, shape, std in own
    ]
    method = FitMethod(
        name=METHOD,
        settings={},
        seed=0,
        objective=solution.loss,
        rows=solution.row_count,
        diagnostics={"selection": "ident diagnose", "bound_to_bodies": bool(structure.bodies)},
    )
    correlation = _written(uncertainty.correlation[np.ix_(order, order)])
    assessed = assessment.model_copy(update={"correlation": correlation}), uncertainties
    agreements = _agreement(model, split.train), _agreement(model, split.test)
    file = model_of(regressions, structure, x, fit, method, prepared.method, assessed, agreements)
    return with_warnings(file.model_copy(update={"residual_test": residual_test(model, unexplained, diagnosed)}))


def _written(correlation: Floats) -> tuple[tuple[float | None, ...], ...]:
    """The matrix `correlation` (k, k) as files hold it."""
    return tuple(tuple(map(number_or_none, row)) for row in correlation)


def _agreement(model: FittedModel, rows: tuple[Bools, ...]) -> Agreement:
    """Agreement of `model` on `rows` (m, dof) of each recording."""
    used = [
        (data, np.where(selected, data.torque, np.nan), computed)
        for data, selected, computed in zip(model.split.recordings, rows, model.computed, strict=True)
        if selected.any()
    ]
    return agreement(*zip(*used, strict=True))
