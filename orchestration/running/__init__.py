"""Runs by co-simulation: the session, what drives it, and what happens on the way."""
