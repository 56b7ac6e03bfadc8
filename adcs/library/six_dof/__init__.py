"""Pan, Wong, Kapila: output feedback for spacecraft with coupled translation and attitude dynamics."""
