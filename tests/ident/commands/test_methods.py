import json

import pytest
from click.testing import CliRunner, Result

from ident.basics import plugins
from ident.estimation import estimators
from ident.program import program

NAMES = plugins.names("ident.estimation.estimators")


def methods(*arguments: str) -> Result:
    return CliRunner().invoke(program, ["methods", *arguments])


def test_all_methods_are_listed_with_their_settings() -> None:
    document = json.loads(methods("--json").stdout)
    assert [method["name"] for method in document["methods"]] == list(NAMES)
    printed = "".join(methods().stdout.split())
    assert all(name in printed for name in (*NAMES, "threshold", "forgetting", "damping", "neighbourhood"))


@pytest.mark.parametrize("name", NAMES)
def test_what_is_shown_of_a_method_can_be_set(name: str) -> None:
    method = json.loads(methods(name, "--json").stdout)["methods"][0]
    shown = {setting["name"]: setting["default"] for setting in method["settings"]}
    assert estimators.settings(name, shown) == estimators.settings(name, {})
    explained = methods(name).stdout
    assert all(
        f"{setting['name']}" in explained and setting["meaning"] in explained for setting in method["settings"]
    )
