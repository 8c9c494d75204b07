"""Pages that are executed several at a time, by kernels that start at once."""
