"""An FMU file as the orchestrator sees it: variables, units, values, what depends on what. Nothing is loaded here."""
