/* y = k u, direct feedthrough; doubled = 2 u, which nothing else depends on */
#include "mock.h"

static int calculate(Mock *m) {
    for (int i = 0; i < 3; ++i) {
        m->v[y + i] = m->v[k] * m->v[u + i];
        m->v[doubled + i] = 2 * m->v[u + i];
    }
    return 0;
}
static int step(Mock *m, double t, double h) {
    return m->v[k] >= 1e9 && m->v[u] > 4 ? say(m, 3, "u is too large for this gain") : 0;
}
static int update(Mock *m) { return 0; }
