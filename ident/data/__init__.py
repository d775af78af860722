"""Turn a recording into a prepared recording: samples, low-pass, preprocessing, noise."""
