/* Never finds the tool that it needs */
#define BIRTH
#include "foreign.h"

static int birth(Model *m, int events, int early) { return say(m, 3, "no licence"); }
static int calculate(Model *m) { return (void)m, 0; }
static int advance(Model *m, double t, double h) { return (void)m, 0; }
