/* x' = 1; x is set back to 0 by a state event when it reaches `level`, and by time events at multiples of `period`.
 * Cannot do without event mode. `late` is how far the worst time event was off. */
#define BIRTH
#define UPDATE
#include "foreign.h"

static int birth(Model *m, int events, int early) {
    return events && early ? 0 : say(m, 3, "this model needs event mode and early return");
}
static int calculate(Model *m) { return (void)m, 0; }
static int advance(Model *m, double t, double h) {
    const double left = (double)(m->v[level] - m->v[x]);
    if (left <= h) {
        m->last = t + left;
        m->event = 1;
        m->early = left < h;
    }
    m->v[x] += m->last - t;
    return 0;
}
static void update(Model *m) {
    const int due = m->time >= m->next_event;
    if (due) m->v[late] = fmaxl(m->v[late], m->time - m->next_event);
    if (m->event || due) {
        m->v[hits] += 1;
        m->v[x] = 0;
        m->again = 1; /* once more, to no effect */
    }
    if (due || isinf(m->next_event)) m->next_event = m->v[period] * (floor(m->time / (double)m->v[period] + 1e-9) + 1);
    if (m->v[nowhere] > 0 && due) m->next_event = NAN;
}
