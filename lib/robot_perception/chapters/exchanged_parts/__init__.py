"""Parts exchanged: what one paper's rule does in another paper's system, drawn."""
