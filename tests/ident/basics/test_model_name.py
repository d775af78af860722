from ident.basics.model_name import model_stem


def test_stem_is_without_the_endings_of_a_model() -> None:
    assert model_stem("a.model.json") == model_stem("a.json") == model_stem("a") == "a"
    assert model_stem("a.better.model.json") == "a.better"
