"""Five backstepping controllers of a micro-satellite in four scenarios: the thesis' chapter 9."""
