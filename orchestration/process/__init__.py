"""What keeps files and the process itself from harm; knows nothing of runs."""
