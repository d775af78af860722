"""State behind the page: one session with its parts."""
