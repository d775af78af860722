"""What failed is looked at once more; what must not be excused is not."""

import subprocess

import pytest

from tests.machinery import second_look
from tests.machinery.conftest import Planted
from tests.machinery.hand_over import Failure, Finished
from tests.machinery.second_look import MOST, failures, finished, main, verdict

BAD = {
    "test_wrong": "def test_wrong():\n    assert 1 == 2\n",
    "test_set_up": "import pytest\n@pytest.fixture\ndef broken():\n    raise OSError\ndef test_it(broken): pass\n",
    "test_power": "from tests.failures import assert_safe\ndef test_power():\n    assert_safe(False, 'drive 2')\n",
    "test_hang": "import time, pytest\n@pytest.mark.timeout(1)\ndef test_hang():\n    time.sleep(1e6)\n",
    "test_late": "from tests.timekeeping import Machine\ndef test_late():\n    Machine().expect(False, 'late')\n",
    "test_good": "def test_good():\n    pass\n",
}
NAMED = {
    ("test_wrong.py", "test"),
    ("test_set_up.py", "test"),
    ("test_power.py", "safety"),
    ("test_late.py", "timing"),
    ("test_hang.py", "test"),
}
CRASH = "import os\ndef test_crash():\n    os._exit(1)\n"


def kinds(planted: Planted) -> set[tuple[str, str]]:
    return {(failure.test.partition("::")[0], failure.kind) for failure in failures(planted.handed)}


def test_what_failed_is_handed_over_and_fails_no_run(planted: Planted) -> None:
    for name, text in BAD.items():
        planted.write(name, text)
    done = planted.run("--hand-to", str(planted.handed))
    assert done.code == 0, done.out
    assert kinds(planted) == NAMED
    (run,) = finished(planted.handed)
    assert (run.passed, run.failed, run.skipped) == (1, len(NAMED), 0)


@pytest.mark.slow
def test_side_by_side_a_crash_is_handed_over_as_one(planted: Planted) -> None:
    for name, text in (BAD | {"test_crash": CRASH}).items():
        planted.write(name, text)
    done = planted.run("--hand-to", str(planted.handed), "-n", "1")
    assert done.code == 0, done.out
    assert done.passed == {"test_good.py::test_good"}
    assert kinds(planted) == NAMED | {("test_crash.py", "crash")}


@pytest.mark.slow
def test_where_nobody_collects_and_where_nothing_is_collected_a_run_fails(planted: Planted) -> None:
    planted.write("test_wrong", BAD["test_wrong"])
    assert planted.run().code == 1
    planted.write("test_broken", "import nothing_of_this_name\n")
    assert planted.run("--hand-to", str(planted.handed)).code == 2


@pytest.mark.parametrize(
    ("failed", "passing", "good", "said"),
    [
        ("", "", True, ""),
        ("a", "a", True, "unsteady: a"),
        ("a", "", False, "failed twice: a"),
        ("ab", "a", False, "unsteady: a, failed twice: b"),
        ("abcdef"[:MOST], "abcdef", True, "unsteady: a, unsteady: b, unsteady: c, unsteady: d, unsteady: e"),
        ("abcdef", "abcdef", False, "6 tests failed; at most 5 are looked at again"),
    ],
)
def test_verdict(failed: str, passing: str, good: bool, said: str) -> None:
    result, lines = verdict([Failure(name, "test") for name in failed], lambda failure: failure.test in passing)
    assert (result, ", ".join(lines)) == (good, said)


@pytest.mark.parametrize("kind", ["safety", "crash"])
def test_safety_and_crashes_are_never_looked_at_again(kind: str) -> None:
    seen: list[str] = []
    failed = [Failure("a", "test"), Failure("b", kind)]  # type: ignore[arg-type]
    good, lines = verdict(failed, lambda failure: seen.append(failure.test) is None)
    assert not good
    assert lines == [f"not looked at again ({kind}): b"]
    assert not seen


def test_a_skip_excuses_only_what_was_late(monkeypatch: pytest.MonkeyPatch) -> None:
    run = Finished("", passed=0, failed=0, skipped=1, share="")
    monkeypatch.setattr(second_look, "finished", lambda folder: [run])
    monkeypatch.setattr("subprocess.run", lambda command, **options: subprocess.CompletedProcess(command, 0))
    assert second_look.passes(Failure("a", "timing"))
    assert not second_look.passes(Failure("a", "test"))


@pytest.mark.slow
def test_second_look_runs_a_test_of_this_folder_once_more(planted: Planted) -> None:
    here = "tests/machinery/test_second_look.py"
    steady, gone = f"{here}::test_verdict[--True-]", f"{here}::test_that_is_not_there"
    planted.handed.mkdir()
    lines = [f'{{"test": "{name}", "kind": "test"}}\n' for name in (steady, gone)]
    (planted.handed / "failed.jsonl").write_text(lines[0])
    assert main(planted.handed) == 0
    assert (planted.handed / "verdict.txt").read_text() == f"unsteady: {steady}\n"
    (planted.handed / "failed.jsonl").write_text("".join(lines))
    assert main(planted.handed) == 1
    assert f"failed twice: {gone}\n" in (planted.handed / "verdict.txt").read_text()
