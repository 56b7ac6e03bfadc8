/* Adds up the time from the steps it takes, and refuses to add up to more than the stop time it was told. `off` is by how
 * many units in the last place, of the largest time so far, the time it is told was off the end of the step before at
 * most, `drift` by what part of a step off the time it added up; `step_seen` is the last step. */
#include "foreign.h"

static int calculate(Model *m) { return (void)m, 0; }
static int advance(Model *m, double t, double h) {
    if (!m->count[0]++) m->given_interval[0] = t;
    double *added = &m->given_interval[0], told = m->time;
    double *largest = &m->given_interval[1];
    *largest = fmax(*largest, fmax(fabs(t), fabs(told)));
    const double unit = nextafter(*largest, INFINITY) - *largest;
    m->v[off] = fmaxl(m->v[off], fabs(t - told) / unit);
    m->v[drift] = fmaxl(m->v[drift], fabs(t - *added) / h);
    m->v[step_seen] = h;
    *added += h;
    return beyond(m, *added) ? 3 : 0;
}
