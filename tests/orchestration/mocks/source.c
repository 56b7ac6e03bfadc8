/* y = offset + slope * time */
#include "mock.h"

static int calculate(Mock *m) {
    for (int i = 0; i < 3; ++i) m->v[y + i] = m->v[offset + i] + m->v[slope] * m->time;
    return 0;
}
static int step(Mock *m, double t, double h) { return 0; }
static int update(Mock *m) { return 0; }
