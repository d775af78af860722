"""The worker process: what it computes, how the page controls it, and what it sends."""
