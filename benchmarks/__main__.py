"""`make bench`: every benchmark, one after the other."""

from benchmarks import cycle, reading

reading.main()
cycle.main()
