"""Three witnesses: drawings, the sessions that the next chapter needs, too, and recordings."""
