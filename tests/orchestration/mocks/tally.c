/* x' = n + level + u where `enable` is true, else u: inputs of every kind; hands n + 1 on. Counts updates. */
#define EVENT
#include "events.h"

static int calculate(Model *m) {
    m->v[der_x] = (m->v[enable] ? m->v[n] + m->v[level] : 0.0) + m->v[u];
    m->v[total] = m->v[x];
    m->v[more] = m->v[n] + 1.0;
    m->v[odd] = fmod(m->v[n], 2.0) != 0.0;
    return 0;
}

static void event(Model *m) { m->v[updates] += 1.0; }
