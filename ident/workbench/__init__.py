"""The browser application of `ident workbench`, served on this machine only."""
