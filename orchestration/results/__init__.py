"""What a run leaves: recordings, results, their files, the manifest, plots and the report."""
