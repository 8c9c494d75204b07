"""The ledger on pages: badges, scorecard, overview, the papers, measured times."""
