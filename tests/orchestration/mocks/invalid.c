/* the sums of two parameters, whose values are lost where their size is set, as the standard allows */
#define RESIZED
#define SIZE m->v[n]
#include "foreign.h"

static int calculate(Model *m) {
    m->v[sums] = m->v[sums + 1] = 0;
    for (int i = 0; i < (int)(SIZE); ++i) {
        m->v[sums] += m->v[same + i];
        m->v[sums + 1] += m->v[each + i];
    }
    return 0;
}
static int advance(Model *m, double t, double h) { return (void)m, 0; }
static int resized(Model *m) {
    for (int i = 0; i < (int)(SIZE); ++i) m->v[same + i] = m->v[each + i] = -99;
    return 0;
}
