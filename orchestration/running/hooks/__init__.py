"""What may happen during a run: a file for each kind, all of them as `orchestration.running.hook` describes."""
