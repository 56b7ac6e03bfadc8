/* An event indicator that falls to zero at 1, rests there until 2, falls on, and rises above zero after 4: it leaves
 * z > 0 at 1 and z <= 0 at 4, and does neither at 2. */
#define EVENT
#include "events.h"

static int calculate(Model *m) {
    const double t = m->time;
    m->v[z1] = t < 1.0 ? 1.0 - t : t < 2.0 ? 0.0 : t < 3.0 ? 2.0 - t : t - 4.0;
    return 0;
}

static void event(Model *m) {
    m->v[events] += m->time > 0.0;
    m->v[sum] += m->time;
}
