/* A swing a'' = -a; counts how often it has risen above a level, and how often it has sunk below. */
#define EVENT
#include "events.h"

static int calculate(Model *m) {
    m->v[der_a] = m->v[b];
    m->v[der_b] = -m->v[a];
    m->v[z1] = m->v[a] - m->v[level];
    m->v[y] = m->v[a];
    return 0;
}

static void event(Model *m) {
    const double now = m->v[z1] > 0.0;
    m->v[rises] += now && !m->v[above];
    m->v[falls] += !now && m->v[above];
    m->v[above] = now;
    m->v[last] = m->time;
}
