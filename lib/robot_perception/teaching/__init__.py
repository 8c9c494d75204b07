"""What turns results into a book: figures, explorers, claims, exercises, shown source."""
