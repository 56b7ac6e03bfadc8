/* x' = u, y = x, three times. Euler in Co-Simulation: exact for a held input. */
#include "mock.h"

static int calculate(Mock *m) {
    for (int i = 0; i < 3; ++i) {
        m->v[der_x + i] = m->v[u + i];
        m->v[y + i] = m->v[x + i];
    }
    return 0;
}
static int step(Mock *m, double t, double h) {
    for (int i = 0; i < 3; ++i) m->v[x + i] += h * m->v[u + i];
    return 0;
}
static int update(Mock *m) { return 0; }
