"""Chapter 4: attitude stabilisation from unit vectors, without a gyro."""
