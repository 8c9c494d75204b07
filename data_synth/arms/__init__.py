"""Upper bodies whose arms move before a camera."""
