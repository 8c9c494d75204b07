"""Round the loop: data association, linearisation and consistency of a filter that comes back."""
