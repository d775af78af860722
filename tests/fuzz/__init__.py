"""Random and mutated input for everything that reads from outside: frames, serial lines, files (`make fuzz`)."""
