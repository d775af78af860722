"""One diagnosis tells one story: document, console, report, saved model, comparison and workbench agree."""

import html
import json
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import ident
from ident.diagnosis.document.result import DiagnosisResult
from ident.dynamics.motion import Motion
from ident.identification import model_file
from ident.output.console import diagnosis as console_diagnosis
from ident.output.console import residuals as console_residuals
from ident.output.report import contents, page
from ident.residuals.analysis import ResidualAnalysis
from ident.workbench.worker.model_views import residual_view
from recordings.recording import Floats, Recording
from tests.ident import building

NOISE = 0.05
SUGGESTS_MORE = (
    "look at",
    "a model could explain",
    "possible cause",
    "not valid for this motion",
    "Above the noise",
    "is structured",
    "structured residual is left that",
    "An unknown effect",
    "An effect is missing",
    "ident diagnose finds",
    "ident diagnose found",
    "a curve over",
    "a wave over its position",
    "check for drift",
)
"""What must not be said where nothing is missing."""
MISSING: dict[str, tuple[str, Callable[[Motion], Floats]]] = {
    "drag": ("quadratic_friction", lambda motion: 0.3 * motion.velocity * np.abs(motion.velocity)),
    "spring": ("joint_spring", lambda motion: 0.8 * motion.position),
    "offset": ("torque_offset", lambda motion: np.full_like(motion.velocity, 0.5)),
    "cogging": ("cogging", lambda motion: 0.3 * np.sin(20 * motion.position)),
    "two ways": ("asymmetric_viscous", lambda motion: 0.3 * np.abs(motion.velocity)),
    "stribeck": (
        "stribeck",
        lambda motion: 0.8 * np.sign(motion.velocity) * np.exp(-((motion.velocity / 0.3) ** 2)),
    ),
    "strong drag": ("quadratic_friction", lambda motion: 0.9 * motion.velocity * np.abs(motion.velocity)),
    "strong spring": ("joint_spring", lambda motion: 3.0 * motion.position),
    "fine cogging": ("cogging", lambda motion: 0.4 * np.cos(31 * motion.position)),
    "strong offset": ("torque_offset", lambda motion: np.full_like(motion.velocity, -1.5)),
}
FAST = ("drag", "stribeck")


@dataclass(frozen=True)
class Story:
    """All that is told about one diagnosis."""

    result: DiagnosisResult
    model: ident.Model
    compared: ResidualAnalysis
    texts: dict[str, str]
    """By place."""


Tell = Callable[..., Story]


@pytest.fixture
def tell(write: Callable[[Recording], Path], tmp_path: Path) -> Tell:
    def story(extra: Callable[[Motion], Floats] | None, seed: int = 0) -> Story:
        files = []
        for shape in (0, 1):
            recording = building.record(noise=NOISE, seed=2 * seed + shape, extra=extra, shape=shape)
            voltage = np.sign(recording.effort) * np.sqrt(np.abs(recording.effort))
            path = tmp_path / f"{shape}.mcap"
            files.append(write(replace(recording, voltage=voltage, effort=None, path=path)))
        train, other = files
        result = ident.diagnose([train], validate=other)
        saved = tmp_path / "m.json"
        result.model.save(saved)
        model = ident.load_model(saved)
        compared = ident.compare(model, [other])
        request = contents.ReportRequest((saved,), (train,), (other,), (), diagnose=True)
        analysed = {saved.name: ident.compare(model, [train])}, {saved.name: compared}
        report = page.render(contents.assemble(request, {saved.name: model.file}, *analysed, result))
        view = residual_view(result.diagnosis.model, True, result.diagnosis.unexplained)
        assert view.model.parameters == model.file.parameters
        texts = {
            "diagnose": printed(lambda console: console_diagnosis.show(result.document, console)),
            "compare": printed(lambda console: console_residuals.show(compared, console)),
            "report": plain(report),
            "workbench": " ".join(view.sentences),
            "json": json.dumps([result.document.sentence, result.document.warnings, compared.as_json()["where"]]),
        }
        return Story(result, model, compared, texts)

    return story


def printed(show: Callable[[Console], None]) -> str:
    console = Console(width=400, record=True, file=None, quiet=False)
    with console.capture() as capture:
        show(console)
    return capture.get()


def plain(page: str) -> str:
    """Visible text of a page, with the texts of its figures."""
    without_library = re.sub(r"<script(?![^>]*json).*?</script>", "", page, flags=re.DOTALL)
    return html.unescape(re.sub(r"<[^>]+>", " ", re.sub(r"<style.*?</style>", "", without_library, flags=re.DOTALL)))


def check_figures(story: Story) -> None:
    """The numbers of all places are the same."""
    document, file = story.result.document, story.model.file
    last = document.steps[-1]
    shown = {entry.name: entry for entry in file.all_parameters}
    assert set(shown) == set(last.parameters)
    for name, value in last.parameters.items():
        entry = shown[name]
        assert (entry.value, entry.ci95, entry.shape_ci95, entry.unit) == (
            pytest.approx(value.value),
            value.ci95,
            value.shape_ci95,
            value.unit,
        )
    assert file.train.fitted.rms == pytest.approx(last.train_rms)
    assert file.validate_.fitted.rms == pytest.approx(last.held_out_rms)
    assert file.residual_test.noise_rms == document.noise_rms
    for joint, error, noise in zip(story.compared.joints, last.held_out_rms, document.noise_rms, strict=True):
        assert joint.summary.rms == pytest.approx(error)
        assert joint.noise_rms == noise
        for place in ("diagnose", "compare"):
            assert f"{error:.3g}" in story.texts[place]
            assert f"{noise:.3g}" in story.texts[place]
    for name, value in last.parameters.items():
        if "." in name:
            assert f"{name} = {value.in_words}" in story.texts["diagnose"]
            assert name in story.texts["report"]


def check_nothing_more(story: Story) -> None:
    assert story.compared.within_noise
    for place, text in story.texts.items():
        for phrase in SUGGESTS_MORE:
            assert phrase not in text, f"{place}: {phrase}"


def check_above_the_noise(bare: ident.Model, other: Path, saved: Path) -> None:
    """Its fit, its comparison and its file say the same of a model that lacks the effect."""
    test = bare.file.residual_test
    assert test.verdict == "above-noise"
    compared = ident.compare(bare, [other])
    assert compared.test == test
    assert test.sentence in " ".join(compared.sentences)
    bare.save(saved)
    assert model_file.load(saved).residual_test == test


@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 10))])
def test_nobody_finds_fault_at_the_floor(tell: Tell, seed: int) -> None:
    story = tell(None, seed)
    assert story.result.verdict == "adequate"
    check_nothing_more(story)
    check_figures(story)


@pytest.mark.parametrize(
    "case", [case if case in FAST else pytest.param(case, marks=pytest.mark.slow) for case in MISSING]
)
def test_all_places_name_the_same_effect_with_the_same_figures(tell: Tell, case: str, tmp_path: Path) -> None:
    effect, torque = MISSING[case]
    story = tell(torque)
    document = story.result.document
    assert document.verdict == "missing-effect"
    names = {finding.effect for finding in document.findings}
    assert names == {effect} == set(story.model.effects)
    for place in ("diagnose", "report"):
        assert effect in story.texts[place]
    check_nothing_more(story)
    check_figures(story)
    assert sum(finding.share or 0.0 for finding in document.findings) == pytest.approx(
        story.result.diagnosis.model.improvement_over(story.result.diagnosis.selection.steps[0].model).share
    )
    train, other = (data.recording.path for data in story.result.diagnosis.split.recordings)
    check_above_the_noise(ident.fit([train], validate=other, method="ls"), other, tmp_path / "bare.json")
