"""Fuzzing of all external inputs with random and mutated data: frames, serial lines, files (`make fuzz`)."""
