"""What a result depends on: cells, definitions, packages; by hashes of these it is found again."""
