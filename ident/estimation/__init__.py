"""Turn prepared recordings into parameters: linear fit, nonlinear least squares, particle swarm."""
