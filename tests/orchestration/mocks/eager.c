/* Clocks of 0.1 s; at the second tick of `changed` the clock `which` (1: retuned, 2: changed, 3: counted) gets an interval
 * that is none, or 0: `wrong` is 1 for NaN, 2 for infinity, 3 for -1, 4 for 0. With `wrong` = 0 nothing is amiss. */
#define UPDATE
#define INTERVAL
#include "foreign.h"

static int calculate(Model *m) {
    if (m->active[changed]) m->v[ticks] = m->count[changed] + 1;
    return 0;
}
static int advance(Model *m, double t, double h) { return (void)m, (void)t, (void)h, 0; }
static void update(Model *m) { m->count[changed] += m->active[changed]; }
static int interval(Model *m, unsigned vr, double *T) {
    const double numbers[] = {0.1, NAN, INFINITY, -1.0, 0.0};
    const int number = m->v[which] == 1 ? retuned : m->v[which] == 2 ? changed : counted;
    const int now = (unsigned)number == vr && m->count[changed] > 1;
    *T = numbers[now ? (int)m->v[wrong] : 0];
    if (vr == counted && !now) return fmi3IntervalNotYetKnown;
    return vr == changed || now || m->mode == INITIALIZATION ? fmi3IntervalChanged : fmi3IntervalUnchanged;
}
