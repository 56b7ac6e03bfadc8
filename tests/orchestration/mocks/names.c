/* y = u, under several names */
#include "foreign.h"

static int calculate(Model *m) {
    for (int i = 0; i < 2; ++i) m->v[y + i] = m->v[u + i];
    return 0;
}
static int advance(Model *m, double t, double h) { return (void)m, 0; }
