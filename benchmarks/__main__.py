"""`make bench`: every benchmark, one after the other."""

from benchmarks import certificate, commands, cycle, reading, swarm, workbench

reading.main()
cycle.main()
certificate.main()
swarm.main()
commands.main()
workbench.main()
