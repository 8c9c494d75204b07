"""The contents of the book, read once for all tests of a worker."""

from robot_perception.teaching.pages.contents import read

CONTENTS = read()
