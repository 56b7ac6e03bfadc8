/* A counter without continuous states, stepped by time events at multiples of the period; `late` is how far the worst
 * of them was off. It ends the simulation with the event number `last`. */
#define EVENT
#include "events.h"

static int calculate(Model *m) { return (void)m, 0; }

static void event(Model *m) {
    if (m->time >= m->next_event) {
        m->v[late] = fmax(m->v[late], m->time - m->next_event);
        m->v[counter] += 1.0;
        m->terminate = m->v[counter] >= m->v[last];
    }
    m->next_event = m->v[nowhere] > 0 && m->v[counter] > 0 ? NAN : (m->v[counter] + 1.0) * m->v[period];
}
