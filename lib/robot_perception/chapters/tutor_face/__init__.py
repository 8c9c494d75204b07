"""Is it you?: faces found, recognised, and followed while they are missed."""
