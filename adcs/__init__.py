"""The command `adcs`, as it is started: `adcs run` in a process that a supervisor looks after."""
