/* No continuous states: an event indicator of time alone, sin(time). */
#define EVENT
#include "events.h"

static int calculate(Model *m) {
    m->v[z1] = sin(m->time);
    return 0;
}

static void event(Model *m) {
    m->v[crossings] += (m->v[z1] > 0.0) != m->v[positive];
    m->v[positive] = m->v[z1] > 0.0;
    m->v[last] = m->time;
}
