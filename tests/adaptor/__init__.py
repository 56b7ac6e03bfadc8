"""The FMI adaptor, called through fmpy."""
