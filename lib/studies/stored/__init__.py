"""What is computed once: rows, long runs and results of recordings, with the keys they fit."""
