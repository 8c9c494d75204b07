"""Ways through the book: contents, paths, cards, source code beside equations."""
