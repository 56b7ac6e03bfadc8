"""In which order values are fetched and handed on, in numbers that the engine executes."""
