"""The application in the browser on this machine: `ident workbench`."""
