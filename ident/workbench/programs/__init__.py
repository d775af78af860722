"""Other programs that the page runs as processes of their own."""
