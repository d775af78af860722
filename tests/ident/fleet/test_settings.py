"""The identity of a recording's rows."""

from ident.fleet.settings import FleetSettings


def test_key_depends_on_content_settings_and_where_a_broken_file_is() -> None:
    settings = FleetSettings()
    keys = {
        settings.key("a"),
        settings.key("b"),
        settings.key("a", "/x.mcap"),
        settings.key("a", "/y.mcap"),
        FleetSettings(cutoff=20.0).key("a"),
        FleetSettings("savgol").key("a"),
    }
    assert len(keys) == 6
    assert settings.key("a") == FleetSettings().key("a")
