"""Whether a mistake in a law would be seen: headers changed in one place, compiled, given to the law's own test."""
