"""Tracking a pattern: sections 3 and 4.1 of Ait Aider et al., "Indoor Autonomous Navigation"."""
