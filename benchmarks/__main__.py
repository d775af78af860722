"""`make bench`: every benchmark, one after the other."""

from benchmarks import certificate, commands, coverage, cycle, reading, swarm, workbench

reading.main()
cycle.main()
certificate.main()
coverage.main()
swarm.main()
commands.main()
workbench.main()
