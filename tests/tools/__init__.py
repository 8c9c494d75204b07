"""Tools of whoever works on the book: commands that are run by hand or by make, and no tests."""
