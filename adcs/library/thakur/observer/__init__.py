"""Chapter 5: PD tracking with the angular velocity that an observer makes of the attitude."""
