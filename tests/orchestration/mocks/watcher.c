/* x' = 1; looks at x after each integrator step, and asks for an event where it has passed the threshold,
 * or after every step, where nothing changes.
 * It ends the simulation after the first step that reaches `ends_at`. */
#define EVENT
#define COMPLETED
#include "events.h"

static int calculate(Model *m) {
    m->v[der_x] = 1.0;
    m->v[y] = m->v[x];
    return 0;
}

static int completed(Model *m) {
    m->v[steps] += 1.0;
    m->terminate = m->time >= m->v[ends_at];
    return m->v[always] > 0 || (m->v[x] > m->v[threshold] && !m->v[fired]);
}

static void event(Model *m) {
    if (m->v[x] > m->v[threshold] && !m->v[fired]) {
        m->v[fired] = 1.0;
        m->v[fired_at] = m->time;
        m->v[x] = 0.0;
        m->values_changed = 1;
    }
}
