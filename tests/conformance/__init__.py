"""The standard's own Reference-FMUs, built from a folder of their published source: here, by fmpy, and checked."""
