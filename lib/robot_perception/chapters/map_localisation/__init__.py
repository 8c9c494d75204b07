"""Localisation ("Where am I?"): a robot that is switched on somewhere in a finished map."""
