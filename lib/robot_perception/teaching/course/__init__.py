"""A class with the book: weeks, exercises, copies of notebooks and their marks."""
