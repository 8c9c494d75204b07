"""Simultaneous localisation and map building."""
