"""What a likelihood looks like: surfaces of cues, hidden parts, and what no contour tells."""
