"""Which landmark is this?: Gil et al., sections 2, 3.1 and 4, Table 1."""
