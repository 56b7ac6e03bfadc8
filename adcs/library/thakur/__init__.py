"""Thakur's dissertation on adaptive, gyro-free and observer-based attitude control; so far Sec. 5.4.1 and 5.4.2."""
