"""FMUs that are loaded: their calls, steps and events. No other room knows fmpy's classes and their private parts."""
