/* Counts how often it is triggered, and doubles the input then */
#define UPDATE
#include "foreign.h"

static int calculate(Model *m) {
    if (!m->active[heard]) return 0;
    m->v[times] = m->count[heard] + 1;
    m->v[twice] = 2 * m->v[u];
    return 0;
}
static int advance(Model *m, double t, double h) { return (void)m, 0; }
static void update(Model *m) { m->count[heard] += m->active[heard]; }
