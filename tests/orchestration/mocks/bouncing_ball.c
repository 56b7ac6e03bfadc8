/* A ball falls, h'' = -g, and bounces with v := -e v where h passes zero. Slower than `rest` it comes to rest. With
 * `lift` it leaves the ground a hair's breadth above zero, as careful models do; without, at zero itself. */
#define EVENT
#include "events.h"

static int calculate(Model *m) {
    m->v[der_h] = m->v[v];
    m->v[der_v] = m->v[resting] ? 0.0 : -m->v[g];
    m->v[z1] = m->v[resting] ? 1.0 : m->v[h];
    m->v[height] = m->v[h];
    m->v[speed] = m->v[v];
    return 0;
}

static void event(Model *m) {
    if (m->v[h] > 0.0 || m->v[v] >= 0.0) return;
    m->v[h] = m->v[lift] ? DBL_MIN : 0.0;
    m->v[v] *= -m->v[e];
    m->v[bounces] += 1.0;
    m->v[last] = m->time;
    if (m->v[v] < m->v[rest]) {
        m->v[v] = 0.0;
        m->v[resting] = 1.0;
    }
    m->values_changed = 1;
}
