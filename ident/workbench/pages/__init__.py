"""Parts of the page. Each module draws one part from the session."""
