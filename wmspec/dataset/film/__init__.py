"""Films of closed sets: their times, drawings, lossless files, and distances."""
