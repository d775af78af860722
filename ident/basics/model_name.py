"""Names of files beside a model."""


def model_stem(file_name: str) -> str:
    """Return the name of a model's file without `.json` and `.model`: "a" of "a.model.json"."""
    return file_name.removesuffix(".json").removesuffix(".model")
