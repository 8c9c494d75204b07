"""One world for all: filters of three papers, beyond each of them."""
