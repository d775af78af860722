"""Drive amplifiers that speak an ASCII protocol over a serial line."""
