"""Tests of the chapter that rides the filters of three papers on one loop."""
