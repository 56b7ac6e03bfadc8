/* x' = 1, y = 2 u. From the step on that reaches `at`, it asks to end the simulation as `how` says: with that step, having
 * taken it (FMI 3); before it, by discarding it (FMI 2 and 3); in the midst of it, at the time `reached` (FMI 3); with that
 * step, having taken it and saying that it discards it, as FMI 2 has it; so also in the midst of it, at `reached`. */
#include "foreign.h"

enum { TAKEN, DISCARDED, EARLY, TAKEN_BY_DISCARD, PART_BY_DISCARD };

static int calculate(Model *m) {
    m->v[y] = 2 * m->v[u];
    return 0;
}
static int advance(Model *m, double t, double h) {
    if (t + h < m->v[at] - 1e-9) return m->v[x] += h, 0;
    m->terminate = 1;
    if (m->v[how] == DISCARDED) return m->last = t, say(m, 2, "landed");
    if (m->v[how] == TAKEN_BY_DISCARD) return m->v[x] += h, m->last = t + h, say(m, 2, "landed");
    if (m->v[how] == PART_BY_DISCARD) {
        m->last = (double)m->v[reached], m->v[x] += m->last - t;
        return say(m, 2, "landed");
    }
    if (m->v[how] == EARLY) m->last = (double)m->v[reached], m->early = 1;
    m->v[x] += m->last - t;
    say(m, 0, "landed");
    return 0;
}
