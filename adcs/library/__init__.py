"""The seed documents as runnable systems, with the printed numbers and claims beside ours."""
