"""One world for all: filters of three papers on one loop."""
