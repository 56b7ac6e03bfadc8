/* Says that it has more continuous states than its description has. */
#define NUMBER
#include "events.h"

static int calculate(Model *m) { return m->v[der_x] = 1.0, 0; }
static int number(Model *m) { return 1 + (int)m->v[more]; }
