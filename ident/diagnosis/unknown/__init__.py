"""What nothing in the library explains: on what it depends, and curves in its place."""
