/* x' = -x with a nominal value for x, which becomes another one at a time event. */
#define EVENT
#include "events.h"

static int calculate(Model *m) {
    m->v[der_x] = -m->v[x];
    m->v[y] = m->v[x];
    return 0;
}

static void event(Model *m) {
    m->nominal[x] = m->time < m->v[change_at] ? m->v[nominal] : m->v[nominal_after];
    m->next_event = m->time < m->v[change_at] ? m->v[change_at] : INFINITY;
    m->nominals_changed = 1;
}
