"""What all of `ident` stands on, and what knows nothing of robots: filters, statistics, threads, plugins, caches."""
