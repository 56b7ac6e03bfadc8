"""A running co-simulation as a MAVLink vehicle, for ground stations and autopilots."""
