"""Many numbers: drawings of ellipses, of a map that grows, of what sensors see, of honesty."""
