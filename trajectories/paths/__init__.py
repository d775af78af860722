"""One built-in path per file; the file's name is the trajectory's, its `motion()` gives the `Motion`."""
