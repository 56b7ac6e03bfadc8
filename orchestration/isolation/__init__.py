"""What keeps a run's rows, files and process from harm: a component may crash, hang, or change the process for all."""
