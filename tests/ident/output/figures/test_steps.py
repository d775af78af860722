"""The figure of the selection steps shows the errors of the document and no name as markup."""

import numpy as np
import pytest

from ident.diagnosis.document.document import Document, Remaining, StepEntry
from ident.output.figures import steps

HOSTILE = "<a href='javascript:alert(1)'>x"


@pytest.fixture
def document() -> Document:
    steps = (
        StepEntry(added=None, effects=(), train_rms=(0.4, 0.5), held_out_rms=(0.8, 0.9), parameters={}),
        StepEntry(added=HOSTILE, effects=(HOSTILE,), train_rms=(0.1, 0.2), held_out_rms=(0.12, 0.22), parameters={}),
        StepEntry(
            added=HOSTILE, effects=(HOSTILE,) * 2, train_rms=(0.1, 0.1), held_out_rms=(0.1, 0.1), parameters={}
        ),
    )
    return Document(
        schema=2,
        verdict="missing-effect",
        sentence="",
        bandwidth_hz=30.0,
        noise_rms=(0.09, 0.08),
        noise_ci95=((0.08, 0.1), (0.07, 0.09)),
        noise_source="repetition",
        explained_share=(1.0, 1.0),
        torque_rms=(5.0, 6.0),
        joints=("joint_1", "joint_2"),
        effort_units=("N m", "N"),
        simulated=True,
        held_out="",
        steps=steps,
        findings=(),
        rejected=(),
        remaining=Remaining(structured_share=0.0, depends_on=(), why="", structured_rms=(0.0, 0.0)),
        next_motion=None,
    )


def test_bars_are_the_errors_and_lines_the_noise(document: Document) -> None:
    figure = steps.error_steps(document)
    bars = [trace for trace in figure.data if trace.type == "bar"]
    assert [trace.name for trace in bars] == ["training", "held out"] * 2
    for joint in range(2):
        train, test = (np.asarray(trace.x) for trace in bars[2 * joint : 2 * joint + 2])
        np.testing.assert_array_equal(train, [step.train_rms[joint] for step in document.steps])
        np.testing.assert_array_equal(test, [step.held_out_rms[joint] for step in document.steps])
    assert [shape.x0 for shape in figure.layout.shapes] == list(document.noise_rms)
    unknown = steps.error_steps(document.model_copy(update={"noise_rms": (None, None)}))
    assert not unknown.layout.shapes
    assert "noise floor" not in {trace.name for trace in unknown.data}
    assert [axis.title.text for axis in figure.select_xaxes()] == ["RMS error [N m]", "RMS error [N]"]


def test_names_are_escaped_and_equal_names_stay_separate(document: Document) -> None:
    figure = steps.error_steps(document)
    assert "<a href" not in figure.to_json()
    assert len(figure.layout.yaxis.ticktext) == 3
    assert list(figure.layout.yaxis.tickvals) == [0, 1, 2]
