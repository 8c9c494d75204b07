"""Raised hands: Haar-like features, boosted to a cascade that is trained here."""
