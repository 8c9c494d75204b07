"""Keys of results: hashes of the cells, definitions and packages that a result depends on."""
