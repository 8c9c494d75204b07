"""Storage of what is computed once: rows, long runs and results of recordings, with their keys."""
