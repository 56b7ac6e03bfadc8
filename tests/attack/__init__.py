"""Attacks on everything that reads: whatever a file or a word holds, a value or one line comes out, and soon."""
