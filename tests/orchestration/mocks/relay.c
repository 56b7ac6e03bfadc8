/* x rises while on and falls while off; off above `high`, on below `low`. Without hysteresis it chatters. */
#define EVENT
#include "events.h"

static int calculate(Model *m) {
    m->v[der_x] = m->v[on] ? 1.0 : -1.0;
    m->v[z1] = m->v[x] - m->v[high];
    m->v[z2] = m->v[low] - m->v[x];
    m->v[y] = m->v[x];
    return 0;
}

static void event(Model *m) {
    const double before = m->v[on];
    if (m->v[x] > m->v[high]) m->v[on] = 0.0;
    if (m->v[x] < m->v[low]) m->v[on] = 1.0;
    m->v[switches] += m->v[on] != before;
}
