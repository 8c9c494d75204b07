"""Follow me: a raised hand, a person followed through the crowd, and the states between."""
