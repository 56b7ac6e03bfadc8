/* x' = gain u + v, w = u, by Euler. In step mode nothing may be fetched after something was set, before the next step. */
#define FETCHED
#include "foreign.h"

static int calculate(Model *m) {
    m->v[w] = m->v[u];
    m->v[unsaid] = m->v[x];
    return 0;
}
static int advance(Model *m, double t, double h) {
    (void)t;
    m->v[x] += h * (m->v[gain] * m->v[u] + m->v[v]);
    return 0;
}
static int fetched(Model *m, unsigned vr) {
    (void)vr;
    return m->given && m->mode == STEP_MODE && m->v[lenient] == 0.0L ? say(m, 3, "get after set without doStep") : 0;
}
