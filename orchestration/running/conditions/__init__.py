"""Conditions on the rows of a run: how their text is read, and which rows meet them."""
