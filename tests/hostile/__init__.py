"""Every public function times a fixed set of wrong values; see `test_hostile`."""
