"""What is looked at in an FMU, one module for each aspect; each yields what is wrong as plain sentences."""
