/* count: how often `period` has passed, by time events in Model Exchange; x' = count */
#include "mock.h"

static double ticks(const Mock *m, double t) { return floor(t / m->v[period] + 1e-9); }

static int calculate(Mock *m) {
    m->v[der_x] = m->v[count];
    m->v[area] = m->v[x];
    return 0;
}
static int step(Mock *m, double t, double h) {
    m->v[x] += h * m->v[count];
    m->v[count] = ticks(m, t + h);
    return 0;
}
static int update(Mock *m) {
    m->v[count] = ticks(m, m->time);
    m->next_event = (m->v[count] + 1) * m->v[period];
    return 0;
}
