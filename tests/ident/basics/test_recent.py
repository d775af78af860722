import pickle

from ident.basics.recent import RecentResults
from ident.basics.threads import in_threads


def test_a_result_is_computed_once() -> None:
    results = RecentResults(2)
    assert [results.get("a", lambda value=value: value) for value in (1, 2)] == [1, 1]


def test_the_least_recently_used_result_is_dropped() -> None:
    results = RecentResults(2)
    for key in "ab":
        results.keep(key, key.upper())
    assert results.find("a") == "A"
    results.keep("c", "C")
    assert [results.find(key) for key in "abc"] == ["A", None, "C"]


def test_threads_get_the_results_of_their_keys() -> None:
    results = RecentResults(3)
    keys = [i % 7 for i in range(500)]
    assert in_threads(lambda key: results.get(key, lambda: 10 * key), keys) == [10 * key for key in keys]


def test_another_process_begins_with_none() -> None:
    """A model that was fitted holds such caches, and is sent to processes and back."""
    results = RecentResults(2)
    results.keep("a", "A")
    other = pickle.loads(pickle.dumps(results))
    assert other.find("a") is None
    assert other.get("a", lambda: "B") == "B"
