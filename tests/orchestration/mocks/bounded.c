/* x' = 1 up to a limit, where x starts again from 0. Just above the limit there are no derivatives. */
#define EVENT
#include "events.h"

static int calculate(Model *m) {
    m->v[der_x] = 1.0;
    m->v[z1] = m->v[limit] - m->v[x];
    m->v[y] = m->v[x];
    return m->v[x] > m->v[limit] * 1.001 ? say(m, m->v[status] ? 2 : 3, "x is out of bounds") : 0;
}

static void event(Model *m) {
    if (m->v[x] < m->v[limit]) return;
    m->v[x] = 0.0;
    m->v[resets] += 1.0;
    m->values_changed = 1;
}
