/* x' = 1 in steps of at most `longest`: longer ones are returned from early; none get on after `stuck`, if not 0.
 * From 0.5 s on `wrong`, if not 0, has them return early at no time of theirs. */
#include "foreign.h"

static int calculate(Model *m) { return (void)m, 0; }
static int advance(Model *m, double t, double h) {
    static const double nowhere[] = {0, NAN, INFINITY, -1};
    if (m->v[wrong] > 0 && t >= 0.5) return m->last = nowhere[(int)m->v[wrong]], m->early = 1, 0;
    if (!m->early_allowed && m->v[wrong] == 0) return say(m, 3, "early return is not allowed");
    if (h > m->v[longest] * 1.000001L) {
        m->last = t + (double)m->v[longest];
        m->early = 1;
    }
    if (m->v[stuck] > 0 && t >= m->v[stuck]) m->last = t + 0 * (m->early = 1);
    if (m->intermediate) {
        bool wanted = true;
        double when = m->last;
        m->intermediate(m->environment, m->last, false, true, true, true, &wanted, &when);
        m->v[asked] += wanted;
    }
    m->v[x] += m->last - t;
    m->v[steps] += 1;
    return 0;
}
