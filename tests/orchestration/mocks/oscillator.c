/* a' = b, b' = u - a */
#include "mock.h"

static int calculate(Mock *m) {
    m->v[der_a] = m->v[b];
    m->v[der_b] = m->v[u] - m->v[a];
    m->v[position] = m->v[a];
    return 0;
}
static int step(Mock *m, double t, double h) {
    const double a0 = m->v[a] - m->v[u], b0 = m->v[b];
    m->v[a] = m->v[u] + a0 * cos(h) + b0 * sin(h);
    m->v[b] = b0 * cos(h) - a0 * sin(h);
    return 0;
}
static int update(Mock *m) { return 0; }
