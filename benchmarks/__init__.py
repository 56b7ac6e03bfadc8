"""What a step costs: the compiled stepping loop against a hand-written C++ loop, fmpy and Basilisk, in CPU time."""
