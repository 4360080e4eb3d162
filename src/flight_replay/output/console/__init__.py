"""Console output: plain lines, or a live display on a terminal."""
