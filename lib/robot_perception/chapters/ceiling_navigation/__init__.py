"""A robot that remembers the ceiling: Ait Aider et al., section 2, eqs 1–3, Fig. 9."""
