"""A running co-simulation as a MAVLink vehicle that ground tools watch and command."""
