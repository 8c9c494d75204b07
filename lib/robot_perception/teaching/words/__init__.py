"""Words of the pages: numbers in prose, what each word means, formulas."""
